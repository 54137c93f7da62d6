// A map of `razer serve`, by its interface /api/v1.
import type { Answer } from "../map_types";
import type { EditState, LiveServer, MapSource } from "./source";

const API = "api/v1";

export class Refused extends Error {
  constructor(
    readonly status: number,
    title: string,
    detail: string,
  ) {
    super(detail || title);
  }
}

async function ask(path: string, options: RequestInit = {}): Promise<Response> {
  const response = await fetch(`${API}/${path}`, { credentials: "same-origin", ...options });
  if (response.ok) return response;
  const problem = await response.json().catch(() => ({}));
  throw new Refused(response.status, problem.title ?? `The server answered ${response.status}`, problem.detail ?? "");
}

async function bytes(path: string): Promise<Uint8Array> {
  return new Uint8Array(await (await ask(path)).arrayBuffer());
}

function json(method: string, content: unknown): RequestInit {
  return { method, headers: { "Content-Type": "application/json" }, body: JSON.stringify(content) };
}

function query(question: string | File): Promise<Answer> {
  if (typeof question === "string") {
    return ask("query", json("POST", { text: question, limit: 50 })).then((response) => response.json());
  }
  const body = new FormData();
  body.append("image", question);
  return ask("query", { method: "POST", body }).then((response) => response.json());
}

const server: LiveServer = {
  query,
  edit: (edit, epoch) => ask("edits", json("POST", { epoch, ...edit })).then(() => undefined),
  undo: (epoch) => ask(`edits/last?epoch=${epoch}`, { method: "DELETE" }).then(() => undefined),
  redo: (epoch) => ask(`edits/redo?epoch=${epoch}`, { method: "POST" }).then(() => undefined),
  editState: () => ask("edits").then((response) => response.json() as Promise<EditState>),
  changes: async (since, decoder) => decoder.blocks(await bytes(`mesh/changes?since=${since}`)),
  cropAddress: (id, n) => `${API}/instances/${id}/crop/${n}.jpg`,
  listen({ edited, grown, born }) {
    const events = new EventSource(`${API}/events`);
    const on = (name: string, tell: (data: Record<string, never>) => void): void =>
      events.addEventListener(name, (event) => tell(JSON.parse((event as MessageEvent<string>).data)));
    on("edit", (data) => edited(data.kind, data.author));
    on("map", (data) => grown(data.revision, data.frame));
    on("instance", (data) => born(data.id, data.name));
  },
};

export function servedSource(): MapSource {
  return { server, load: async (decoder) => decoder.map(await bytes("page")) };
}
