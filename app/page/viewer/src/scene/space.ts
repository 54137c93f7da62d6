// Where the map lies, where its floor is and its ceiling, from a sample of its surface.
import { Vector3 } from "three";
import type { Instance } from "../map_types";
import { NO_CEILING } from "./map_material";
import type { Viewport } from "./viewport";

const SAMPLE = 20_000;
const DOWN = -0.75;
const LEAST_SHARE = 0.02; // of the surface that has to look down for it to be a ceiling
const LEAST_ROOM_M = 1.9;

export interface Space {
  center: Vector3;
  radius: number;
  floorY: number;
  ceilingY: number;
  points: Vector3[]; // a sample of the surface
  azimuth: number; // from where most of the surface shows its face
}

export function measure(viewport: Viewport, instances: Instance[]): Space {
  const sample = viewport.surfaces.sample(SAMPLE);
  const points = sample.map(({ position }) => viewport.toPage(position));
  if (!points.length) return { center: new Vector3(), radius: 3, floorY: -1.5, ceilingY: NO_CEILING, points, azimuth: 0.7 };
  const bounds = (["x", "y", "z"] as const).map((axis) => {
    const sorted = points.map((point) => point[axis]).sort((a, b) => a - b);
    return [quantile(sorted, 0.01), quantile(sorted, 0.99)];
  });
  const low = new Vector3(...bounds.map(([value]) => value));
  const high = new Vector3(...bounds.map(([, value]) => value));
  const center = low.clone().add(high).multiplyScalar(0.5);
  const floors = instances.filter(({ name }) => name === "floor").map(({ center_m }) => viewport.toPage(center_m).y);
  const floorY = floors.length ? Math.min(...floors) : low.y;
  const downward = sample
    .map(({ normal }, i) => ({ y: points[i].y, down: viewport.toPage(normal).y < DOWN }))
    .filter(({ y, down }) => down && y > floorY + LEAST_ROOM_M)
    .map(({ y }) => y)
    .sort((a, b) => a - b);
  const named = instances.filter(({ name }) => name === "ceiling").map(({ center_m }) => viewport.toPage(center_m).y);
  const hasCeiling = named.length > 0 || downward.length > LEAST_SHARE * points.length;
  const ceilingY = !hasCeiling ? NO_CEILING : (named.length ? Math.min(...named) : quantile(downward, 0.5)) - 0.12;
  const normals = sample.map(({ normal }) => viewport.toPage(normal));
  return { center, radius: 0.5 * high.distanceTo(low), floorY, ceilingY, points, azimuth: facing(normals) };
}

/** Of eight directions from above the one that most of the surface faces. */
function facing(normals: Vector3[]): number {
  const share = (azimuth: number): number => {
    const from = new Vector3(Math.sin(azimuth), 0.75, Math.cos(azimuth)).normalize();
    return normals.reduce((sum, normal) => sum + Math.max(normal.dot(from), 0), 0);
  };
  const azimuths = Array.from({ length: 8 }, (_, i) => (i * Math.PI) / 4 + 0.62);
  return azimuths.reduce((best, azimuth) => (share(azimuth) > 1.03 * share(best) ? azimuth : best));
}

function quantile(sorted: number[], share: number): number {
  return sorted[Math.floor(share * (sorted.length - 1))];
}
