// What the page knows of a map: the JSON of the packet's header and of the server's interface.

export type Vector3 = [number, number, number];

export interface Guess {
  name: string;
  probability: number;
}

export interface Instance {
  id: number;
  name: string;
  probability: number | null;
  class_guesses: Guess[];
  kind: "thing" | "stuff";
  score: number;
  center_m: Vector3;
  extent_m: Vector3;
  orientation: [Vector3, Vector3, Vector3];
  n_frames: number;
  first_frame: number;
  last_frame: number;
  parts: number[];
  part_of: number | null;
  crops: number;
  edited: boolean;
  vertices: number;
}

export interface Relation {
  subject: number;
  relation: string;
  object: number;
}

export interface CameraPath {
  stamps_s: number[];
  positions_m: Vector3[];
  quaternions: [number, number, number, number][];
}

export interface MeshHeader {
  vertices: number;
  triangles: number;
  origin_m: Vector3;
  quantum_m: number;
  color_shift: number;
  occlusion_shift: number;
  ids: number[];
}

export interface OtherHeader {
  mesh: MeshHeader;
  camera_path: CameraPath | null;
}

export interface MapHeader {
  format: number;
  epoch: number;
  title: string;
  up: Vector3;
  instances: Instance[];
  relations: Relation[];
  kinds: Record<string, string[]>;
  notes: string[];
  camera_path: CameraPath | null;
  camera: { width: number; height: number; fx: number; fy: number } | null;
  crops: Record<string, number[]>;
  mesh: MeshHeader | null;
  other: OtherHeader | null;
  growing?: boolean;
}

/** A surface ready for the graphics card; triangles stand by instance, `ranges` says [id, first index, count]. */
export interface SurfaceArrays {
  positions: Float32Array;
  normals: Int8Array; // four a vertex
  colors: Uint8Array; // red, green, blue, openness
  ids: Float32Array;
  triangles: Uint32Array;
  ranges: [number, number, number][];
}

export interface LoadedMap {
  header: MapHeader;
  surface: SurfaceArrays;
  other: SurfaceArrays | null;
  crops: Map<number, Blob[]>;
}

export interface Hit {
  id: number;
  name: string;
  probability: number;
  score?: number;
  runner_up: Guess | null;
}

export interface Answer {
  found: boolean;
  statement: string;
  hits: Hit[];
}
