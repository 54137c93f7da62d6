// Changed blocks of a growing map (app/page/mesh_blocks.py): plain arrays, block after block.
import type { SurfaceArrays } from "../map_types";
import type { Packet } from "./packet";
import { surfaceOf } from "./surface";

export interface BlocksHeader {
  format: number;
  revision: number;
  epoch: number;
  blocks: { key: [number, number, number]; vertices: number; triangles: number }[];
}

export interface ChangedBlocks {
  revision: number;
  epoch: number;
  blocks: { key: string; surface: SurfaceArrays | null }[];
}

export function decodeBlocks({ header, sections }: Packet<BlocksHeader>): ChangedBlocks {
  // Sections need not lie at multiples of four bytes.
  const words = (name: string): ArrayBuffer => sections.get(name)!.slice().buffer;
  const positions = new Float32Array(words("positions"));
  const colors = sections.get("colors")!;
  const ids = new Int32Array(words("instances"));
  const triangles = new Uint32Array(words("triangles"));
  let vertex = 0;
  let corner = 0;
  const blocks = header.blocks.map((block) => {
    const vertices = [vertex, (vertex += block.vertices)];
    const corners = [corner, (corner += 3 * block.triangles)];
    if (!block.triangles) return { key: block.key.join(), surface: null };
    const surface = surfaceOf({
      positions: positions.slice(3 * vertices[0], 3 * vertices[1]),
      colors: opaque(colors.subarray(3 * vertices[0], 3 * vertices[1])),
      ids: Float32Array.from(ids.subarray(...(vertices as [number, number]))),
      triangles: triangles.slice(...(corners as [number, number])),
    });
    return { key: block.key.join(), surface };
  });
  return { revision: header.revision, epoch: header.epoch, blocks };
}

/** Colours with an openness: that of growing maps is not known. */
function opaque(colors: Uint8Array): Uint8Array {
  const result = new Uint8Array((colors.length / 3) * 4).fill(255);
  for (let v = 0; 3 * v < colors.length; v++) result.set(colors.subarray(3 * v, 3 * v + 3), 4 * v);
  return result;
}
