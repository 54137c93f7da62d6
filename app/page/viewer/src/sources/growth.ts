// A map that changes while one looks at it: edits of others, and a run that goes on.
import type { App } from "../app";
import { say } from "../panels/toast";
import type { LiveServer } from "./source";

const CALM_MS = 400; // several events at once are one
const RECORDS_MS = 3000; // between looks at the instances of a growing map

export class Growth {
  private revision = 0;
  private busy = false;
  private again = false;
  private recordsAt = 0;
  private reloadTimer = 0;

  constructor(
    private readonly app: App,
    private readonly server: LiveServer,
  ) {
    server.listen({
      edited: () => this.reloadSoon(),
      grown: (revision) => void this.grow(revision),
      born: (id, name) => say(`New: ${name} ${id}`, 2),
    });
    void app.editing.refresh();
    if (app.model.header.growing) void this.grow(1);
  }

  private reloadSoon(): void {
    clearTimeout(this.reloadTimer);
    this.reloadTimer = window.setTimeout(() => void this.app.reload(), CALM_MS);
  }

  /** Brings the blocks that changed; what comes meanwhile is brought after. */
  private async grow(revision: number): Promise<void> {
    if (revision <= this.revision) return;
    if (this.busy) {
      this.again = true;
      return;
    }
    this.busy = true;
    try {
      const changed = await this.server.changes(this.revision, this.app.decoder);
      if (this.revision === 0 && changed.blocks.length) this.app.viewport.surfaces.set("map", null);
      for (const { key, surface } of changed.blocks) this.app.viewport.surfaces.set(`block ${key}`, surface);
      this.revision = changed.revision;
      this.app.grown();
      if (performance.now() - this.recordsAt > RECORDS_MS) {
        this.recordsAt = performance.now();
        await this.app.reload();
      }
    } catch (error) {
      say((error as Error).message);
    }
    this.busy = false;
    if (this.again) {
      this.again = false;
      await this.grow(this.revision + 1);
    }
  }
}
