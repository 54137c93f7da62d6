// The camera's path through the map: a line to see, and a ride along it.
import { BufferGeometry, Float32BufferAttribute, Line, LineBasicMaterial, Quaternion, Vector3 } from "three";
import type { CameraPath } from "../map_types";
import type { Navigation } from "./navigation";
import { OVERLAY, type Viewport } from "./viewport";

const SPEED_UP = 1;

export class CameraTrack {
  onTime: (share: number) => void = () => {};
  private line: Line | null = null;
  private path: CameraPath | null = null;
  private time_s = 0;
  private playing = false;

  constructor(
    private readonly viewport: Viewport,
    private readonly navigation: Navigation,
  ) {}

  show(path: CameraPath | null, color: number): void {
    if (this.line) this.viewport.overlay.remove(this.line);
    this.path = path;
    this.line = null;
    if (!path || path.positions_m.length < 2) return;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new Float32BufferAttribute(path.positions_m.flat(), 3));
    this.line = new Line(geometry, new LineBasicMaterial({ color, transparent: true, opacity: 0.85 }));
    this.line.layers.set(OVERLAY);
    this.line.visible = false;
    this.viewport.overlay.add(this.line);
  }

  setLineVisible(visible: boolean): void {
    if (this.line) this.line.visible = visible;
    this.viewport.draw();
  }

  get duration_s(): number {
    return this.path?.stamps_s.at(-1) ?? 0;
  }

  play(): void {
    if (!this.path || this.playing) return;
    if (this.time_s >= this.duration_s) this.time_s = 0;
    this.playing = true;
    this.viewport.animate((elapsed) => {
      if (!this.playing) return false;
      this.seek((this.time_s + SPEED_UP * elapsed) / Math.max(this.duration_s, 1e-6));
      if (this.time_s >= this.duration_s) this.playing = false;
      return this.playing;
    });
  }

  pause(): void {
    this.playing = false;
  }

  get isPlaying(): boolean {
    return this.playing;
  }

  /** Looks as the camera did at a share of the path. */
  seek(share: number): void {
    if (!this.path) return;
    this.time_s = Math.min(Math.max(share, 0), 1) * this.duration_s;
    const { stamps_s, positions_m, quaternions } = this.path;
    let next = stamps_s.findIndex((stamp) => stamp >= this.time_s);
    if (next < 1) next = Math.min(1, stamps_s.length - 1);
    const before = Math.max(next - 1, 0);
    const part = (this.time_s - stamps_s[before]) / Math.max(stamps_s[next] - stamps_s[before], 1e-6);
    const between = Math.min(Math.max(part, 0), 1);
    const start = new Vector3(...positions_m[before]);
    const position = start.lerp(new Vector3(...positions_m[next]), between);
    const turn = new Quaternion(...quaternions[before]).slerp(new Quaternion(...quaternions[next]), between);
    // Cameras of recordings look along their z axis.
    const ahead = new Vector3(0, 0, 1).applyQuaternion(turn);
    const eye = this.viewport.toPage(position.toArray());
    const target = eye.clone().addScaledVector(this.viewport.toPage(ahead.toArray()), 1.5);
    this.navigation.set({ position: eye.toArray(), target: target.toArray() });
    this.onTime(this.duration_s ? this.time_s / this.duration_s : 0);
  }
}
