// A map that changes while one looks at it.
import type { App } from "../app";
import type { LiveServer } from "./source";

export class Growth {
  constructor(readonly app: App, readonly server: LiveServer) {}
}
