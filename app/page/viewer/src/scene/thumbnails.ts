// Pictures of single instances drawn from the map, for those without a crop; one after the other.
import { Box3, Matrix4, PerspectiveCamera, Scene, Vector3, WebGLRenderTarget } from "three";
import type { Instance } from "../map_types";
import { mapMaterial, mapUniforms } from "./map_material";
import { readBack } from "./read_back";
import type { Viewport } from "./viewport";

const SIZE = 224;

export class Thumbnails {
  private readonly target = new WebGLRenderTarget(SIZE, SIZE);
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(30, 1, 0.01, 100);
  private readonly uniforms;
  private readonly material;
  private queue: Promise<unknown> = Promise.resolve();

  constructor(
    private readonly viewport: Viewport,
    private readonly known: (id: number) => Instance | undefined,
  ) {
    this.uniforms = { ...mapUniforms(viewport.table) };
    this.uniforms.reveal.value = 1;
    this.material = mapMaterial(this.uniforms);
  }

  draw(id: number): Promise<Blob | null> {
    const result = this.queue.then(idle).then(() => this.drawn(id));
    this.queue = result.catch(() => null);
    return result.catch(() => null);
  }

  private async drawn(id: number): Promise<Blob | null> {
    const instance = this.known(id);
    const parts = this.viewport.surfaces.partsOf(id, this.material);
    if (!instance || !parts.length) return null;
    this.uniforms.table.value = this.viewport.table.texture;
    this.uniforms.rows.value = this.viewport.table.rows;
    this.scene.clear();
    this.scene.add(...parts);
    for (const part of parts) {
      part.matrixAutoUpdate = false;
      part.matrix.copy(this.viewport.root.matrixWorld);
    }
    this.aim(instance);
    const { renderer } = this.viewport;
    renderer.setRenderTarget(this.target);
    renderer.setClearColor(0x000000, 0);
    renderer.clear();
    renderer.render(this.scene, this.camera);
    const pixels = new Uint8Array(4 * SIZE * SIZE);
    await readBack(this.viewport, this.target, pixels);
    return pictureOf(pixels);
  }

  /** From where the camera of the recording looked, roughly: the middle of the map, and from above. */
  private aim(instance: Instance): void {
    const turn = new Matrix4().makeRotationFromQuaternion(this.viewport.root.quaternion);
    const at = new Vector3(...instance.center_m).applyMatrix4(turn);
    const axes = instance.orientation.map((row) => new Vector3(...row));
    const box = new Box3();
    for (const signs of [-1, 1].flatMap((x) => [-1, 1].flatMap((y) => [-1, 1].map((z) => [x, y, z])))) {
      const half = signs.map((sign, i) => (sign * instance.extent_m[i]) / 2);
      const corner = new Vector3(...axes.map((row) => row.x * half[0] + row.y * half[1] + row.z * half[2]));
      box.expandByPoint(corner.applyMatrix4(turn));
    }
    const radius = 0.5 * box.getSize(new Vector3()).length();
    const side = new Vector3(-at.x, 0, -at.z).add(new Vector3(...this.middle).setY(0));
    const direction = (side.length() > 0.2 ? side.normalize() : side.set(0.6, 0, 0.8)).setY(0.7).normalize();
    this.camera.position.copy(at).addScaledVector(direction, (0.92 * radius) / Math.sin((15 * Math.PI) / 180));
    this.camera.lookAt(at);
  }

  middle: [number, number, number] = [0, 0, 0];
}

/** Waits until the page has nothing better to do. */
function idle(): Promise<void> {
  return new Promise((resolve) => {
    if ("requestIdleCallback" in window) requestIdleCallback(() => resolve(), { timeout: 400 });
    else setTimeout(resolve, 30);
  });
}

function pictureOf(pixels: Uint8Array): Promise<Blob | null> {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = SIZE;
  const context = canvas.getContext("2d")!;
  const image = context.createImageData(SIZE, SIZE);
  for (let row = 0; row < SIZE; row++) {
    image.data.set(pixels.subarray(4 * SIZE * row, 4 * SIZE * (row + 1)), 4 * SIZE * (SIZE - 1 - row));
  }
  context.putImageData(image, 0, 0);
  return new Promise((resolve) => canvas.toBlob(resolve));
}
