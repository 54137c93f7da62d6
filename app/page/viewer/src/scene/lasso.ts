// A free line around what is meant, drawn over the map.
import { Matrix4 } from "three";
import type { Region } from "../sources/source";
import { byId } from "../panels/elements";
import type { Viewport } from "./viewport";

const STEP_PX = 4;
const FEWEST = 6;
const MOST = 400;

/** Waits for a line; tells its region in the view at its end, null for one too short. Returns what calls it off. */
export function lassoOf(viewport: Viewport, done: (region: Region | null) => void): () => void {
  const ink = byId<HTMLCanvasElement>("ink");
  const context = ink.getContext("2d")!;
  let points: [number, number][] = [];
  const stop = (): void => {
    ink.hidden = true;
    ink.onpointerdown = ink.onpointermove = ink.onpointerup = null;
  };
  const add = ({ offsetX, offsetY }: PointerEvent): void => {
    const last = points.at(-1);
    if (last && Math.hypot(offsetX - last[0], offsetY - last[1]) < STEP_PX) return;
    points.push([offsetX, offsetY]);
    draw(context, points);
  };
  ink.hidden = false;
  ink.width = ink.clientWidth;
  ink.height = ink.clientHeight;
  ink.onpointerdown = (event) => {
    ink.setPointerCapture(event.pointerId);
    points = [];
    add(event);
  };
  ink.onpointermove = (event) => {
    if (event.buttons && points.length) add(event);
  };
  ink.onpointerup = () => {
    stop();
    done(points.length < FEWEST ? null : regionOf(viewport, points));
  };
  return stop;
}

export function regionOf(viewport: Viewport, points: [number, number][]): Region {
  const { camera, root, canvas } = viewport;
  camera.updateMatrixWorld();
  root.updateMatrixWorld();
  const matrix = new Matrix4()
    .multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse)
    .multiply(root.matrixWorld);
  const step = Math.ceil(points.length / MOST);
  const polygon = points
    .filter((_, i) => i % step === 0)
    .map(([x, y]) => [(2 * x) / canvas.clientWidth - 1, 1 - (2 * y) / canvas.clientHeight] as [number, number]);
  // three.js keeps matrices by columns.
  return { lasso: { clip_from_world: matrix.clone().transpose().toArray(), polygon } };
}

function draw(context: CanvasRenderingContext2D, points: [number, number][]): void {
  context.clearRect(0, 0, context.canvas.width, context.canvas.height);
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  context.closePath();
  context.fillStyle = "rgb(31 102 200 / 0.18)";
  context.strokeStyle = "rgb(31 102 200)";
  context.lineWidth = 2;
  context.fill();
  context.stroke();
}
