// The search: by name and kind in the page itself, by any words or a picture where a server answers.
import type { Answer } from "../map_types";
import type { LiveServer } from "../sources/source";
import type { MapModel } from "../state/map_model";
import type { Store } from "../state/store";
import { byId, icon, make } from "./elements";

const WAIT_MS = 140;

export class Search {
  private readonly field = byId<HTMLInputElement>("question");
  private readonly statement = byId("statement");
  private timer = 0;
  private asked = 0;

  constructor(
    private readonly store: Store,
    private readonly model: () => MapModel,
    private readonly server: LiveServer | null,
    private readonly found: (ids: number[]) => void,
  ) {
    this.field.oninput = () => {
      clearTimeout(this.timer);
      this.timer = window.setTimeout(() => this.byName(this.field.value), WAIT_MS);
    };
    byId("search").addEventListener("submit", (event) => {
      event.preventDefault();
      clearTimeout(this.timer);
      if (this.server && this.field.value.trim()) void this.ask(this.field.value.trim());
      else this.byName(this.field.value, true);
    });
    if (server) this.offerPictures();
  }

  focus(): void {
    this.field.focus();
    this.field.select();
  }

  /** Takes up a search from a link. */
  restore(text: string): void {
    this.field.value = text;
    if (this.server) void this.ask(text);
    else this.byName(text, false);
  }

  clear(): void {
    this.field.value = "";
    this.byName("");
  }

  byName(text: string, shows = false): void {
    this.asked++;
    if (!text.trim()) {
      this.store.set({ search: "", hits: null });
      this.tell("");
      return;
    }
    const ids = [...this.model().matching(text)];
    const isOpen = this.server && !ids.length; // the question may yet be answered: nothing is faded for it
    this.store.set({ search: text.trim(), hits: isOpen ? null : new Map(ids.map((id) => [id, this.sureness(id)])) });
    const more = this.server ? " Press Enter to ask in any words." : "";
    const count = ids.length === 1 ? "One thing" : `${ids.length} things`;
    this.tell(ids.length ? `${count} by this name or kind.${more}` : `Nothing in this map has this name or kind.${more}`);
    if (shows && ids.length) this.found(ids);
  }

  private async ask(question: string | File): Promise<void> {
    const number = ++this.asked;
    const text = typeof question === "string" ? question : "";
    this.tell("Asking …");
    try {
      const answer = await this.server!.query(question);
      if (number === this.asked) this.show(text, answer);
    } catch (error) {
      if (number === this.asked) this.tell((error as Error).message);
    }
  }

  private show(text: string, { found, statement, hits }: Answer): void {
    this.store.set({ search: text, hits: new Map(hits.map(({ id, probability }) => [id, probability])) });
    this.tell(statement);
    const doubtful = hits.filter(({ runner_up }) => runner_up);
    if (doubtful.length) {
      const rows = doubtful.slice(0, 5).map(({ id, runner_up }) =>
        make("li", {}, `${this.model().label(id)}: or ${runner_up!.name} (${Math.round(100 * runner_up!.probability)} %)`));
      this.statement.append(make("ul", {}, ...rows));
    }
    if (found) this.found(hits.map(({ id }) => id));
  }

  /** How sure a name is, where it is known. */
  private sureness(id: number): number {
    return this.model().byId.get(id)!.probability ?? 1;
  }

  private tell(text: string): void {
    this.statement.textContent = text;
  }

  private offerPictures(): void {
    this.field.placeholder = "Ask in any words";
    const input = make("input", { type: "file", accept: "image/png,image/jpeg", className: "unseen", "aria-label": "A picture" });
    input.onchange = () => input.files?.[0] && void this.ask(input.files[0]);
    const label = "Search by a picture";
    const button = make("button", { type: "button", className: "icon-button", title: label, "aria-label": label,
      onclick: () => input.click() }, icon("image"));
    input.tabIndex = -1;
    byId("search").append(button, input);
  }
}
