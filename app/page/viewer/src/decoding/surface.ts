// From a decoded mesh to what the graphics card takes: normals, and triangles in the order of their instances.
import type { SurfaceArrays } from "../map_types";
import type { RawMesh } from "./mesh_decoder";

export function surfaceOf(mesh: RawMesh): SurfaceArrays {
  const owners = turnedToOwners(mesh);
  return { ...mesh, normals: normals(mesh), ...byInstance(mesh.triangles, owners) };
}

/** Whose each triangle is: that of two of its corners, or else of the last. Triangles are turned so that their last
 * corner, which flat shading goes by, is of that instance. */
function turnedToOwners({ triangles, ids }: RawMesh): Int32Array {
  const owners = new Int32Array(triangles.length / 3);
  for (let t = 0; t < owners.length; t++) {
    const [a, b, c] = triangles.subarray(3 * t, 3 * t + 3);
    const owner = ids[a] === ids[b] ? ids[a] : ids[c];
    if (ids[c] !== owner) triangles.set([c, a, b], 3 * t);
    owners[t] = owner;
  }
  return owners;
}

function byInstance(triangles: Uint32Array, owners: Int32Array): Pick<SurfaceArrays, "triangles" | "ranges"> {
  const counts = new Map<number, number>();
  for (const owner of owners) counts.set(owner, (counts.get(owner) ?? 0) + 1);
  const next = new Map<number, number>();
  const ranges: [number, number, number][] = [];
  let start = 0;
  for (const id of [...counts.keys()].sort((a, b) => a - b)) {
    next.set(id, start);
    ranges.push([id, start, 3 * counts.get(id)!]);
    start += 3 * counts.get(id)!;
  }
  const sorted = new Uint32Array(triangles.length);
  for (let t = 0; t < owners.length; t++) {
    const place = next.get(owners[t])!;
    sorted[place] = triangles[3 * t];
    sorted[place + 1] = triangles[3 * t + 1];
    sorted[place + 2] = triangles[3 * t + 2];
    next.set(owners[t], place + 3);
  }
  return { triangles: sorted, ranges };
}

/** Normals of the vertices as signed bytes, four a vertex, weighted by the areas of their triangles. */
export function normals({ positions, triangles }: Pick<RawMesh, "positions" | "triangles">): Int8Array {
  const sums = new Float32Array(positions.length);
  for (let i = 0; i < triangles.length; i += 3) {
    const a = 3 * triangles[i];
    const b = 3 * triangles[i + 1];
    const c = 3 * triangles[i + 2];
    const ux = positions[b] - positions[a];
    const uy = positions[b + 1] - positions[a + 1];
    const uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a];
    const vy = positions[c + 1] - positions[a + 1];
    const vz = positions[c + 2] - positions[a + 2];
    const x = uy * vz - uz * vy;
    const y = uz * vx - ux * vz;
    const z = ux * vy - uy * vx;
    for (const corner of [a, b, c]) {
      sums[corner] += x;
      sums[corner + 1] += y;
      sums[corner + 2] += z;
    }
  }
  const result = new Int8Array((4 * positions.length) / 3);
  for (let v = 0; 3 * v < sums.length; v++) {
    const length = Math.hypot(sums[3 * v], sums[3 * v + 1], sums[3 * v + 2]) || 1;
    for (let i = 0; i < 3; i++) result[4 * v + i] = Math.round((127 * sums[3 * v + i]) / length);
  }
  return result;
}
