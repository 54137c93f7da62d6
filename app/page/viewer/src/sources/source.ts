// Where a map comes from, and what else that place can do.
import type { Decoder } from "../decoding/decoder";
import type { ChangedBlocks } from "../decoding/blocks";
import type { Answer, LoadedMap } from "../map_types";

export type Region =
  | { plane: { normal: [number, number, number]; offset_m: number } }
  | { lasso: { clip_from_world: number[]; polygon: [number, number][] } };

export type Edit =
  | { kind: "rename"; instance: number; name: string }
  | { kind: "relabel"; instance: number; class: string }
  | { kind: "merge"; instances: number[] }
  | { kind: "delete"; instance: number }
  | { kind: "split"; instance: number; region: Region }
  | { kind: "move_border"; from: number; to: number; region: Region };

export interface EditState {
  can_undo: boolean;
  can_redo: boolean;
}

export interface Listeners {
  edited(kind: string, author: string | null): void;
  grown(revision: number, frame: number): void;
  born(id: number, name: string): void;
}

export interface LiveServer {
  query(question: string | File): Promise<Answer>;
  edit(edit: Edit, epoch: number): Promise<void>;
  undo(epoch: number): Promise<void>;
  redo(epoch: number): Promise<void>;
  editState(): Promise<EditState>;
  changes(since: number, decoder: Decoder): Promise<ChangedBlocks>;
  cropAddress(id: number, n: number): string;
  listen(listeners: Listeners): void;
}

export interface MapSource {
  load(decoder: Decoder): Promise<LoadedMap>;
  server: LiveServer | null;
}
