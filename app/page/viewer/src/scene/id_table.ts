// What is known of each instance id, as a texture that the shaders look ids up in: three colours, and how it is shown.
import { DataTexture, NearestFilter, RGBAFormat, UnsignedByteType } from "three";
import type { Rgb } from "../state/palette";

const WIDTH = 256;
const LAYERS = 4;

export interface Shown {
  visible: boolean;
  hit: number; // probability that a query means it, 0 = it does not
  lit: boolean; // pointed at
}

export class IdTable {
  texture!: DataTexture;
  rows = 0;
  private bytes!: Uint8Array;

  constructor() {
    this.reach(0);
  }

  /** Makes room for ids up to this one; what was known is forgotten when it has to grow. */
  reach(maxId: number): boolean {
    const rows = Math.floor(maxId / WIDTH) + 1;
    if (rows <= this.rows) return false;
    this.texture?.dispose();
    this.rows = rows;
    this.bytes = new Uint8Array(4 * WIDTH * rows * LAYERS);
    this.texture = new DataTexture(this.bytes, WIDTH, rows * LAYERS, RGBAFormat, UnsignedByteType);
    this.texture.minFilter = this.texture.magFilter = NearestFilter;
    return true;
  }

  setColors(id: number, instance: Rgb, category: Rgb, confidence: Rgb): void {
    [instance, category, confidence].forEach((color, layer) => this.write(layer, id, [...color, 255]));
  }

  setShown(id: number, { visible, hit, lit }: Shown): void {
    this.write(3, id, [visible ? 255 : 0, Math.round(255 * hit), lit ? 255 : 0, 255]);
  }

  upload(): void {
    this.texture.needsUpdate = true;
  }

  private write(layer: number, id: number, texel: number[]): void {
    const place = layer * WIDTH * this.rows + id;
    if (id < WIDTH * this.rows) this.bytes.set(texel, 4 * place);
  }
}
