// The list of instances by class, with pictures and counts.
import type { Instance } from "../map_types";
import type { MapModel } from "../state/map_model";
import { sizeText } from "../state/map_model";
import { css } from "../state/palette";
import type { Store } from "../state/store";
import type { Pictures } from "../state/pictures";
import { byId, make } from "./elements";

export class ListPanel {
  private readonly holder = byId("list");
  private readonly count = byId("count");
  private readonly rows = new Map<number, HTMLButtonElement>();
  private readonly closed = new Set<string>();

  constructor(
    private readonly store: Store,
    private readonly pictures: Pictures,
    private readonly choose: (id: number) => void,
  ) {}

  show(model: MapModel, shown: Set<number>): void {
    const { state } = this.store;
    this.rows.clear();
    const things = model.instances.filter((instance) => shown.has(instance.id));
    const wholes = things.filter((instance) => instance.part_of === null || state.hits?.has(instance.id));
    const groups = new Map<string, Instance[]>();
    for (const instance of wholes) {
      groups.set(instance.name, [...(groups.get(instance.name) ?? []), instance]);
    }
    const order = [...groups].sort(([a, of_a], [b, of_b]) => rank(of_a) - rank(of_b) || a.localeCompare(b));
    this.holder.replaceChildren(...order.map(([name, members]) => this.group(model, name, members)));
    if (!order.length) this.holder.append(make("p", { className: "empty" }, "Nothing to list with these filters."));
    const total = model.instances.filter((instance) => instance.part_of === null).length;
    const counted = wholes.length === total ? `${total}` : `${wholes.length} of ${total}`;
    this.count.textContent = `${counted} ${total === 1 ? "instance" : "instances"} in ${groups.size} ${groups.size === 1 ? "class" : "classes"}`;
    this.mark();
  }

  /** Shows which row is chosen or pointed at. */
  mark(): void {
    const { selected, hovered } = this.store.state;
    for (const [id, row] of this.rows) {
      row.setAttribute("aria-pressed", String(id === selected));
      row.classList.toggle("hovered", id === hovered);
    }
  }

  reveal(id: number): void {
    const row = this.rows.get(id);
    if (!row) return;
    row.closest("details")!.open = true;
    row.scrollIntoView({ block: "nearest" });
  }

  private group(model: MapModel, name: string, members: Instance[]): HTMLElement {
    const { hits } = this.store.state;
    const swatch = make("span", { className: "swatch" });
    swatch.style.background = css(model.colorAt(members[0], 2));
    const badge = make("span", { className: "badge" }, String(members.length));
    const details = make("details", { open: !this.closed.has(name) },
      make("summary", {}, swatch, make("span", { className: "class-name" }, name), badge));
    details.addEventListener("toggle", () => (details.open ? this.closed.delete(name) : this.closed.add(name)));
    const best = (instance: Instance): number => hits?.get(instance.id) ?? 0;
    const sorted = [...members].sort((a, b) => best(b) - best(a) || b.score - a.score || a.id - b.id);
    details.append(make("ul", {}, ...sorted.map((instance) => make("li", {}, this.row(model, instance)))));
    return details;
  }

  private row(model: MapModel, instance: Instance): HTMLElement {
    const { mode, hits } = this.store.state;
    const { id } = instance;
    const probability = hits?.get(id);
    const picture = make("span", { className: "thumb" });
    this.pictures.into(picture, id);
    const dot = make("span", { className: "dot" });
    dot.style.background = css(model.colorAt(instance, mode));
    const percent = probability ?? instance.probability;
    const chance = percent === null ? "" : `${Math.round(100 * percent)} %`;
    const row = make("button", {
      type: "button",
      className: "row",
      onclick: () => this.choose(id),
      onpointerenter: () => this.store.set({ hovered: id }),
      onpointerleave: () => this.store.set({ hovered: null }),
    }, picture,
      make("span", { className: "row-text" },
        make("span", { className: "row-name" }, dot, model.label(id)),
        make("span", { className: "row-size" }, sizeText(instance.extent_m))),
      make("span", { className: probability === undefined ? "chance" : "chance hit" }, chance));
    this.rows.set(id, row);
    return row;
  }
}

/** Things before surfaces. */
const rank = (members: Instance[]): number => (members[0].kind === "stuff" ? 1 : 0);
