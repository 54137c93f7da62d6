// The worker that unpacks maps, so that the page answers meanwhile.
import type { MapHeader, SurfaceArrays } from "../map_types";
import { decodeBlocks, type BlocksHeader } from "./blocks";
import { decodeMesh } from "./mesh_decoder";
import { base64Bytes, gunzip, parsePacket, type Packet } from "./packet";
import { surfaceOf } from "./surface";

export interface Request {
  number: number;
  what: "map" | "blocks";
  data: string | Uint8Array;
}

const NOTHING: SurfaceArrays = {
  positions: new Float32Array(),
  normals: new Int8Array(),
  colors: new Uint8Array(),
  ids: new Float32Array(),
  triangles: new Uint32Array(),
  ranges: [],
};

self.onmessage = async ({ data }: MessageEvent<Request>) => {
  try {
    const bytes = typeof data.data === "string" ? base64Bytes(data.data) : data.data;
    const unpacked = await gunzip(bytes);
    const result = data.what === "map" ? mapOf(parsePacket<MapHeader>(unpacked)) : blocksOf(unpacked);
    postMessage({ number: data.number, result: result.value }, { transfer: result.transfer });
  } catch (error) {
    postMessage({ number: data.number, problem: String(error) });
  }
};

function mapOf({ header, sections }: Packet<MapHeader>) {
  const section = (prefix: string) => (name: string) => sections.get(prefix + name) ?? new Uint8Array();
  const surface = header.mesh ? surfaceOf(decodeMesh(header.mesh, section(""))) : NOTHING;
  const other = header.other ? surfaceOf(decodeMesh(header.other.mesh, section("other_"))) : null;
  const crops = sections.get("crops") ?? new Uint8Array();
  const pictures = new Map<number, Blob[]>();
  let start = 0;
  for (const [id, sizes] of Object.entries(header.crops)) {
    const files = sizes.map((size) => new Blob([crops.slice(start, (start += size))], { type: "image/jpeg" }));
    pictures.set(Number(id), files);
  }
  return { value: { header, surface, other, crops: pictures }, transfer: [...buffers(surface), ...buffers(other)] };
}

function blocksOf(unpacked: Uint8Array) {
  const value = decodeBlocks(parsePacket<BlocksHeader>(unpacked));
  return { value, transfer: value.blocks.flatMap((block) => buffers(block.surface)) };
}

function buffers(surface: SurfaceArrays | null): ArrayBuffer[] {
  if (!surface || surface === NOTHING) return [];
  const { positions, normals, colors, ids, triangles } = surface;
  return [positions, normals, colors, ids, triangles].map((array) => array.buffer as ArrayBuffer);
}
