// Orbiting, flying to things, and walking about.
import { Euler, MathUtils, Vector3, type Quaternion } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Instance } from "../map_types";
import type { Space } from "./space";
import type { Viewport } from "./viewport";

export interface View {
  position: [number, number, number];
  target: [number, number, number];
}

const FLIGHT_S = 0.9;
const HOME_SLOPE = 1.0;
const ROOM_FOR_MAP = 0.88; // share of the picture
const EYE_M = 1.55;
const WALK_M_PER_S = 1.8;
const TURN_PER_PX = 0.0035;
const ORBIT_FOV = 50;
const WALK_FOV = 68;

export class Navigation {
  readonly controls: OrbitControls;
  walking = false;
  onMoved: () => void = () => {};
  private readonly keys = new Set<string>();
  private readonly steps = (elapsed_s: number): boolean => this.stroll(elapsed_s);
  private readonly look = new Euler(0, 0, 0, "YXZ");
  private floorY = 0;
  private center = new Vector3();
  private radius = 3;
  private points: Vector3[] = [];
  private azimuth = 0.6;
  private stopFlight: () => void = () => {};

  constructor(private readonly viewport: Viewport) {
    const { camera, canvas } = viewport;
    this.controls = new OrbitControls(camera, canvas);
    Object.assign(this.controls, { enableDamping: true, dampingFactor: 0.12, zoomToCursor: true, maxPolarAngle: 2.6 });
    this.controls.minDistance = 0.15;
    this.controls.addEventListener("start", () => this.stopFlight());
    this.controls.addEventListener("change", () => this.moved());
    canvas.addEventListener("pointermove", (event) => this.turn(event));
    canvas.addEventListener("blur", () => this.keys.clear());
  }

  /** Where the map lies, in the page's frame. */
  setSpace({ center, radius, floorY, points, azimuth }: Space): void {
    Object.assign(this, { center, radius, floorY, points, azimuth });
    this.controls.maxDistance = 6 * radius;
  }

  home(): View {
    const direction = new Vector3(Math.sin(this.azimuth), HOME_SLOPE, Math.cos(this.azimuth)).normalize();
    const aside = new Vector3(0, 1, 0).cross(direction).normalize();
    const over = direction.clone().cross(aside);
    const half = Math.tan(MathUtils.degToRad(ORBIT_FOV / 2)) * ROOM_FOR_MAP;
    const wide = half * this.viewport.camera.aspect;
    // As near as all points of the sample still fit between the four sides of the picture.
    const needed = this.points.map((point) => {
      const at = point.clone().sub(this.center);
      const beside = Math.max(Math.abs(at.dot(aside)) / wide, Math.abs(at.dot(over)) / half);
      return at.dot(direction) + beside;
    }).sort((a, b) => a - b);
    const distance = needed.length ? needed[Math.floor(0.995 * (needed.length - 1))] : 3 * this.radius;
    const target = this.center.clone().addScaledVector(over, -0.05 * distance);
    return view(target.clone().addScaledVector(direction, distance), target);
  }

  get view(): View {
    const { camera } = this.viewport;
    const ahead = camera.getWorldDirection(new Vector3());
    const target = this.walking ? camera.position.clone().addScaledVector(ahead, 2) : this.controls.target;
    return view(camera.position, target);
  }

  set(to: View): void {
    this.stopFlight();
    this.viewport.camera.position.set(...to.position);
    this.controls.target.set(...to.target);
    this.controls.update();
    this.viewport.draw();
  }

  /** Stays before what it sees where a map that is known better has been turned. */
  turnWith(turn: Quaternion): void {
    if (this.walking) return;
    const { position, target } = this.view;
    const [at, to] = [position, target].map((point) => new Vector3(...point).applyQuaternion(turn));
    this.set(view(at, to));
  }

  /** Flies there, or is there at once where motion is not wanted. */
  fly(to: View): void {
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) return this.set(to);
    this.stopFlight();
    const from = this.view;
    const start = { position: new Vector3(...from.position), target: new Vector3(...from.target) };
    const end = { position: new Vector3(...to.position), target: new Vector3(...to.target) };
    let passed = 0;
    this.stopFlight = this.viewport.animate((elapsed) => {
      passed = Math.min(passed + elapsed / FLIGHT_S, 1);
      const share = passed * passed * (3 - 2 * passed);
      this.viewport.camera.position.lerpVectors(start.position, end.position, share);
      this.controls.target.lerpVectors(start.target, end.target, share);
      this.controls.update();
      return passed < 1;
    });
  }

  /** A view of an instance from the open side of the room, a little from above. */
  viewOf(instance: Instance): View {
    const at = this.viewport.toPage(instance.center_m);
    const size = Math.max(Math.hypot(...instance.extent_m), 0.3);
    const open = new Vector3(this.center.x - at.x, 0, this.center.z - at.z);
    const current = this.viewport.camera.position.clone().sub(at).setY(0);
    const side = open.length() > 0.25 * this.radius ? open.normalize() : current.normalize();
    const distance = Math.min(Math.max(1.5 * size, 1.1), 1.5 * this.radius);
    const direction = side.add(new Vector3(0, 0.75, 0)).normalize();
    return view(at.clone().addScaledVector(direction, distance), at);
  }

  /** Stands up where the view turned about, or `from` where one walked before; or leaves. */
  walk(on: boolean, from: View | null = null): void {
    if (on === this.walking) return;
    const { camera } = this.viewport;
    this.stopFlight();
    this.walking = on;
    this.controls.enabled = !on;
    camera.fov = on ? WALK_FOV : ORBIT_FOV;
    camera.updateProjectionMatrix();
    if (on) {
      const inside = this.controls.target.clone().setY(this.floorY + EYE_M);
      const away = this.center.clone().sub(inside).setY(0);
      this.look.set(-0.08, away.length() > 0.3 ? Math.atan2(-away.x, -away.z) : this.look.y, 0);
      camera.position.copy(inside);
      if (from) {
        camera.position.set(...from.position);
        camera.lookAt(...from.target);
        this.look.setFromQuaternion(camera.quaternion);
      }
      this.viewport.animate(this.steps);
    } else {
      const ahead = camera.getWorldDirection(new Vector3());
      this.controls.target.copy(camera.position).addScaledVector(ahead, 2);
      this.fly(this.home());
    }
    this.viewport.draw();
  }

  /** Goes to stand on a point of the floor. */
  stepTo(point: Vector3): void {
    const { camera } = this.viewport;
    const start = camera.position.clone();
    const end = point.clone().setY(this.floorY + EYE_M);
    let passed = 0;
    this.stopFlight = this.viewport.animate((elapsed) => {
      passed = Math.min(passed + elapsed / FLIGHT_S, 1);
      camera.position.lerpVectors(start, end, passed * passed * (3 - 2 * passed));
      return passed < 1 && this.walking;
    });
  }

  key(code: string, down: boolean): void {
    if (down) this.keys.add(code);
    else this.keys.delete(code);
    if (this.walking) this.viewport.animate(this.steps);
    else if (down) this.orbitByKey(code);
  }

  private orbitByKey(code: string): void {
    const turns: Record<string, [number, number]> = {
      ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1],
    };
    const turn = turns[code];
    if (!turn) return;
    const { camera } = this.viewport;
    const offset = camera.position.clone().sub(this.controls.target);
    const radius = offset.length();
    const polar = MathUtils.clamp(Math.acos(offset.y / radius) + turn[1], 0.05, 2.6);
    const azimuth = Math.atan2(offset.x, offset.z) + turn[0];
    offset.setFromSphericalCoords(radius, polar, azimuth);
    this.set(view(this.controls.target.clone().add(offset), this.controls.target));
  }

  private stroll(elapsed_s: number): boolean {
    if (!this.walking) return false;
    const { camera } = this.viewport;
    camera.quaternion.setFromEuler(this.look);
    const pressed = (...codes: string[]): number => (codes.some((code) => this.keys.has(code)) ? 1 : 0);
    const ahead = pressed("KeyW", "ArrowUp") - pressed("KeyS", "ArrowDown");
    const aside = pressed("KeyD") - pressed("KeyA");
    this.look.y += 1.6 * elapsed_s * (pressed("ArrowLeft", "KeyQ") - pressed("ArrowRight", "KeyE"));
    const step = new Vector3(aside, 0, -ahead).applyAxisAngle(new Vector3(0, 1, 0), this.look.y);
    const pace = this.keys.has("ShiftLeft") ? 2.2 : 1;
    camera.position.addScaledVector(step, pace * WALK_M_PER_S * elapsed_s);
    this.onMoved();
    return this.keys.size > 0;
  }

  private turn(event: PointerEvent): void {
    if (!this.walking || !event.buttons) return;
    this.look.y += TURN_PER_PX * event.movementX;
    this.look.x = MathUtils.clamp(this.look.x + TURN_PER_PX * event.movementY, -1.3, 1.3);
    this.viewport.animate(this.steps);
  }

  private moved(): void {
    this.onMoved();
    // Damping goes on after the pointer is let go.
    this.viewport.animate(() => !this.walking && this.controls.update());
  }
}

function view(position: Vector3, target: Vector3): View {
  return { position: position.toArray(), target: target.toArray() };
}
