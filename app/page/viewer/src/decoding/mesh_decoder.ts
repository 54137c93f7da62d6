// Undoes app/page/mesh_codec.py: triangles hang on edges of earlier ones, vertices are guessed from them.
import type { MeshHeader } from "../map_types";
import { bit, joinPlanes, unzigzag } from "./packet";

const ROOT = 3;

export interface RawMesh {
  positions: Float32Array;
  colors: Uint8Array; // red, green, blue, openness
  ids: Float32Array;
  triangles: Uint32Array;
}

type Sections = (name: string) => Uint8Array;

interface Connectivity {
  triangles: Uint32Array;
  guesses: Int32Array; // three a vertex: the ends of the edge and the corner across
}

export function decodeMesh(header: MeshHeader, sections: Sections): RawMesh {
  const { triangles, guesses } = connectivity(header, sections);
  return {
    triangles,
    positions: positions(header, sections, guesses),
    colors: colors(header, sections, guesses),
    ids: instanceIds(header, sections, guesses),
  };
}

function connectivity(header: MeshHeader, sections: Sections): Connectivity {
  const count = header.triangles;
  const edges = sections("edge");
  let roots = 0;
  for (let t = 0; t < count; t++) if (edges[t] === ROOT) roots++;
  const steps = joinPlanes(sections("parent_step"), count - roots);
  const isNew = sections("is_new");
  const back = joinPlanes(sections("back"), sections("back").length / 3);
  const triangles = new Uint32Array(3 * count);
  const guesses = new Int32Array(3 * header.vertices);
  let parent = 0;
  let hung = 0;
  let corner = 0;
  let old = 0;
  let fresh = 0;
  const next = (): number => (bit(isNew, corner++) ? fresh++ : fresh - back[old++]);
  for (let t = 0; t < count; t++) {
    const at = 3 * t;
    if (edges[t] === ROOT) {
      for (let i = 0; i < 3; i++) {
        const vertex = fresh;
        triangles[at + i] = next();
        if (fresh > vertex) guesses.fill(vertex - 1, 3 * vertex, 3 * vertex + 3);
      }
      continue;
    }
    parent += steps[hung++];
    const e = edges[t];
    const start = triangles[3 * parent + ((e + 1) % 3)];
    const end = triangles[3 * parent + e];
    const vertex = fresh;
    triangles[at] = start;
    triangles[at + 1] = end;
    triangles[at + 2] = next();
    if (fresh > vertex) {
      guesses[3 * vertex] = start;
      guesses[3 * vertex + 1] = end;
      guesses[3 * vertex + 2] = triangles[3 * parent + ((e + 2) % 3)];
    }
  }
  return { triangles, guesses };
}

function positions(header: MeshHeader, sections: Sections, guesses: Int32Array): Float32Array {
  const n = header.vertices;
  const result = new Float32Array(3 * n);
  ["x", "y", "z"].forEach((axis, place) => {
    const lattice = unzigzag(joinPlanes(sections(`position_${axis}`), n));
    const origin = header.origin_m[place];
    for (let v = 0; v < n; v++) {
      const a = guesses[3 * v];
      if (a >= 0) lattice[v] += lattice[a] + lattice[guesses[3 * v + 1]] - lattice[guesses[3 * v + 2]];
      result[3 * v + place] = origin + header.quantum_m * lattice[v];
    }
  });
  return result;
}

/** Values that were written as differences from the mean of an edge. */
function fromMean(section: Uint8Array, guesses: Int32Array, n: number): Int32Array {
  const values = unzigzag(joinPlanes(section, n));
  for (let v = 0; v < n; v++) {
    const a = guesses[3 * v];
    if (a >= 0) values[v] += (values[a] + values[guesses[3 * v + 1]]) >> 1;
  }
  return values;
}

function colors(header: MeshHeader, sections: Sections, guesses: Int32Array): Uint8Array {
  const n = header.vertices;
  const [green, red, blue] = ["green", "red", "blue"].map((name) => fromMean(sections(`color_${name}`), guesses, n));
  const openness = fromMean(sections("occlusion"), guesses, n);
  const scale = 255 / (255 >> header.color_shift);
  const opennessScale = 255 / (255 >> header.occlusion_shift);
  const result = new Uint8Array(4 * n);
  for (let v = 0; v < n; v++) {
    result[4 * v] = scale * (red[v] + green[v]);
    result[4 * v + 1] = scale * green[v];
    result[4 * v + 2] = scale * (blue[v] + green[v]);
    result[4 * v + 3] = opennessScale * openness[v];
  }
  return result;
}

function instanceIds(header: MeshHeader, sections: Sections, guesses: Int32Array): Float32Array {
  const n = header.vertices;
  const differs = sections("instance_differs");
  const written = joinPlanes(sections("instance"), sections("instance").length / 2);
  const slots = new Int32Array(n);
  let place = 0;
  for (let v = 0; v < n; v++) {
    const guess = guesses[3 * v + 1];
    slots[v] = bit(differs, v) ? written[place++] : guess >= 0 ? slots[guess] : 0;
  }
  return Float32Array.from(slots, (slot) => header.ids[slot] ?? 0);
}
