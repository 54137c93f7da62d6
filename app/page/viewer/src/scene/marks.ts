// Lines over the map: the box of what is chosen, and the ruler.
import { BufferGeometry, Float32BufferAttribute, LineBasicMaterial, LineSegments, Points, PointsMaterial, Vector3 } from "three";
import type { Instance } from "../map_types";
import { OVERLAY, type Viewport } from "./viewport";

const EDGES = [0, 1, 2, 3, 4, 5, 6, 7, 0, 2, 1, 3, 4, 6, 5, 7, 0, 4, 1, 5, 2, 6, 3, 7];

export class BoxMark {
  private readonly lines = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ transparent: true, opacity: 0.55 }));

  constructor(private readonly viewport: Viewport) {
    this.lines.layers.set(OVERLAY);
    this.lines.material.color.set(0x2f7de1);
    this.lines.frustumCulled = false;
    viewport.overlay.add(this.lines);
    this.lines.visible = false;
  }

  show(instance: Instance | null): void {
    this.lines.visible = instance !== null;
    if (instance) {
      const corners = boxCorners(instance);
      const points = EDGES.flatMap((corner) => corners[corner].toArray());
      this.lines.geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
    }
    this.viewport.draw();
  }
}

export function boxCorners({ center_m, extent_m, orientation }: Instance): Vector3[] {
  return Array.from({ length: 8 }, (_, corner) => {
    const half = extent_m.map((extent, i) => (corner & (1 << i) ? 0.5 : -0.5) * extent);
    const at = center_m.map((value, row) => value + orientation[row].reduce((sum, axis, i) => sum + axis * half[i], 0));
    return new Vector3(...at);
  });
}

/** Two points and their distance; the label is an element of the page that follows them. */
export class Ruler {
  private points: Vector3[] = [];
  private readonly line = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: 0xd9480f, depthTest: false }));
  private readonly dots = new Points(new BufferGeometry(), new PointsMaterial({ color: 0xd9480f, size: 8, sizeAttenuation: false, depthTest: false }));

  constructor(
    private readonly viewport: Viewport,
    private readonly label: HTMLElement,
  ) {
    for (const mark of [this.line, this.dots]) {
      mark.layers.set(OVERLAY);
      mark.frustumCulled = false;
      mark.renderOrder = 2;
      viewport.scene.add(mark);
    }
    viewport.onFrame(() => this.place());
    this.clear();
  }

  clear(): void {
    this.points = [];
    this.update();
  }

  /** The next point, in the page's frame; returns the distance once there are two. */
  add(point: Vector3): number | null {
    this.points = this.points.length === 2 ? [point] : [...this.points, point];
    this.update();
    return this.points.length === 2 ? this.points[0].distanceTo(this.points[1]) : null;
  }

  private update(): void {
    const numbers = this.points.flatMap((point) => point.toArray());
    const isWhole = this.points.length === 2;
    this.dots.geometry.setAttribute("position", new Float32BufferAttribute(numbers, 3));
    this.line.geometry.setAttribute("position", new Float32BufferAttribute(isWhole ? numbers : [], 3));
    this.dots.visible = this.points.length > 0;
    this.line.visible = isWhole;
    this.label.hidden = !isWhole;
    if (isWhole) this.label.textContent = distanceText(this.points[0].distanceTo(this.points[1]));
    this.viewport.draw();
  }

  private place(): void {
    if (this.points.length !== 2) return;
    const { camera, canvas } = this.viewport;
    const at = this.points[0].clone().lerp(this.points[1], 0.5).project(camera);
    this.label.hidden = at.z > 1;
    this.label.style.left = `${((at.x + 1) / 2) * canvas.clientWidth}px`;
    this.label.style.top = `${((1 - at.y) / 2) * canvas.clientHeight}px`;
  }
}

export function distanceText(distance_m: number): string {
  return distance_m < 1 ? `${(100 * distance_m).toFixed(1)} cm` : `${distance_m.toFixed(2)} m`;
}
