// What lies under the pointer: the map drawn once more into a single pixel that holds ids and places, read back later so
// that nobody waits for the graphics card.
import { FloatType, NearestFilter, Vector3, WebGLRenderTarget } from "three";
import { pickMaterial } from "./map_material";
import { readBack } from "./read_back";
import { OVERLAY, type Viewport } from "./viewport";

export interface Picked {
  id: number; // 0 = surface of nobody
  point: Vector3; // in the page's frame
}

export class Picker {
  private readonly target = new WebGLRenderTarget(1, 1, {
    type: FloatType,
    minFilter: NearestFilter,
    magFilter: NearestFilter,
  });
  private readonly material;
  private readonly values = new Float32Array(4);
  private running: Promise<Picked | null> = Promise.resolve(null);

  constructor(private readonly viewport: Viewport) {
    this.material = pickMaterial(viewport.uniforms);
  }

  /** One after the other: the buffer is shared. */
  at(x_px: number, y_px: number): Promise<Picked | null> {
    this.running = this.running.then(() => this.read(x_px, y_px)).catch(() => null);
    return this.running;
  }

  private async read(x_px: number, y_px: number): Promise<Picked | null> {
    const { renderer, scene, camera, canvas } = this.viewport;
    camera.setViewOffset(canvas.clientWidth, canvas.clientHeight, x_px, y_px, 1, 1);
    camera.layers.disable(OVERLAY);
    scene.overrideMaterial = this.material;
    renderer.setRenderTarget(this.target);
    renderer.setClearColor(0, 0);
    renderer.clear();
    renderer.render(scene, camera);
    scene.overrideMaterial = null;
    camera.layers.enable(OVERLAY);
    camera.clearViewOffset();
    await readBack(this.viewport, this.target, this.values);
    const [id, x, y, z] = this.values;
    return id < 0.5 ? null : { id: Math.round(id) - 1, point: new Vector3(x, y, z) };
  }
}
