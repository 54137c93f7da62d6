// Edits by hand on a served map.
import type { App } from "../app";
import type { Instance } from "../map_types";
import type { Picked } from "../scene/picker";
import type { Tool } from "../state/store";

export class EditTools {
  constructor(private readonly app: App) {}
  forInstance(_instance: Instance): HTMLElement | null { return this.app ? null : null; }
  picked(_picked: Picked | null): void {}
  toolChanged(_tool: Tool): void {}
}
