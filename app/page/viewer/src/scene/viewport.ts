// Canvas, camera and frames: a frame is drawn when something asks for it, not all the time.
import { Group, PerspectiveCamera, Quaternion, Scene, Vector3, WebGLRenderer } from "three";
import { IdTable } from "./id_table";
import { mapMaterial, mapUniforms, NO_CEILING, type MapUniforms } from "./map_material";
import { Surfaces } from "./surfaces";

export const OVERLAY = 1; // the layer of lines and marks, which picking does not see
type Step = (elapsed_s: number) => boolean;

export class Viewport {
  readonly renderer: WebGLRenderer;
  readonly camera = new PerspectiveCamera(50, 1, 0.03, 200);
  readonly scene = new Scene();
  readonly root = new Group(); // turns the map's upward direction to the page's, +y
  readonly overlay = new Group(); // in the map's frame, too
  readonly table = new IdTable();
  readonly uniforms: MapUniforms = mapUniforms(this.table);
  readonly surfaces = new Surfaces(mapMaterial(this.uniforms));
  ceilingY = NO_CEILING;
  hidesCeiling = true;
  framesDrawn = 0;
  private readonly steps = new Set<Step>();
  private readonly afterFrame: (() => void)[] = [];
  private asked = false;
  private last = 0;

  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, powerPreference: "high-performance" });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.autoClear = false;
    this.camera.layers.enable(OVERLAY);
    this.root.add(this.surfaces.group, this.overlay);
    this.scene.add(this.root);
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement!);
    this.resize();
  }

  /** Puts the map upright; returns how that turned it. */
  setUp(up: [number, number, number]): Quaternion {
    const before = this.root.quaternion.clone();
    this.root.quaternion.setFromUnitVectors(new Vector3(...up).normalize(), new Vector3(0, 1, 0));
    this.root.updateMatrixWorld();
    return this.root.quaternion.clone().multiply(before.invert());
  }

  /** A point of the map in the page's frame. */
  toPage(point: [number, number, number]): Vector3 {
    return new Vector3(...point).applyQuaternion(this.root.quaternion);
  }

  /** A point of the page's frame in the map's. */
  toMap(point: Vector3): Vector3 {
    return point.clone().applyQuaternion(this.root.quaternion.clone().invert());
  }

  /** The table may be another texture after it grew. */
  refreshTable(): void {
    this.table.upload();
    this.uniforms.table.value = this.table.texture;
    this.uniforms.rows.value = this.table.rows;
    this.draw();
  }

  /** Called on every frame until it returns false. */
  animate(step: Step): () => void {
    this.steps.add(step);
    this.draw();
    return () => this.steps.delete(step);
  }

  onFrame(listener: () => void): void {
    this.afterFrame.push(listener);
  }

  /** Whether a frame was asked for that is not drawn yet. */
  get isAsked(): boolean {
    return this.asked;
  }

  /** Asks for a frame. */
  draw(): void {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame((time) => this.frame(time));
  }

  render(): void {
    const above = this.camera.position.y > this.ceilingY;
    this.uniforms.ceilingY.value = above && this.hidesCeiling ? this.ceilingY : NO_CEILING;
    this.framesDrawn++;
    this.renderer.setRenderTarget(null);
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
    for (const listener of this.afterFrame) listener();
  }

  private frame(time: number): void {
    this.asked = false;
    const elapsed = Math.min((time - this.last) / 1000, 0.1);
    this.last = time;
    for (const step of [...this.steps]) if (!step(elapsed)) this.steps.delete(step);
    this.render();
    if (this.steps.size) this.draw();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas.parentElement!;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.draw();
  }
}
