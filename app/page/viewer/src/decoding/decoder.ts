// Asks the worker, which is made of a text inside the page so that it works from file://.
import WORKER_TEXT from "worker-text";
import type { LoadedMap } from "../map_types";
import type { ChangedBlocks } from "./blocks";
import type { Request } from "./worker";

type Reply = { number: number; result?: unknown; problem?: string };

export class Decoder {
  private readonly worker: Worker;
  private readonly waiting = new Map<number, (reply: Reply) => void>();
  private asked = 0;

  constructor() {
    const address = URL.createObjectURL(new Blob([WORKER_TEXT], { type: "text/javascript" }));
    this.worker = new Worker(address);
    this.worker.onmessage = ({ data }: MessageEvent<Reply>) => {
      this.waiting.get(data.number)?.(data);
      this.waiting.delete(data.number);
    };
  }

  map(data: string | Uint8Array): Promise<LoadedMap> {
    return this.ask("map", data) as Promise<LoadedMap>;
  }

  blocks(data: Uint8Array): Promise<ChangedBlocks> {
    return this.ask("blocks", data) as Promise<ChangedBlocks>;
  }

  private ask(what: Request["what"], data: string | Uint8Array): Promise<unknown> {
    const number = this.asked++;
    return new Promise((resolve, reject) => {
      this.waiting.set(number, ({ result, problem }) => (problem ? reject(new Error(problem)) : resolve(result)));
      const request: Request = { number, what, data };
      this.worker.postMessage(request, typeof data === "string" ? [] : [data.buffer as ArrayBuffer]);
    });
  }
}
