// The card of one instance: pictures, size, guesses, frames, parts, relations.
import type { Instance } from "../map_types";
import type { Link, MapModel } from "../state/map_model";
import { sizeText } from "../state/map_model";
import { css } from "../state/palette";
import type { Pictures } from "../state/pictures";
import { byId, iconButton, make } from "./elements";

export interface CardActions {
  choose: (id: number) => void;
  fly: (id: number) => void;
  isolate: (id: number) => void;
  close: () => void;
  editTools: (instance: Instance) => HTMLElement | null;
}

export class Card {
  private readonly holder = byId("card");

  constructor(
    private readonly pictures: Pictures,
    private readonly actions: CardActions,
  ) {}

  hide(): void {
    this.holder.hidden = true;
    this.holder.replaceChildren();
  }

  show(model: MapModel, instance: Instance, isolated: boolean): void {
    const { id } = instance;
    const { actions } = this;
    const dot = make("span", { className: "dot" });
    dot.style.background = css(model.colorAt(instance, 1));
    const isolate = iconButton("isolate", "Show it alone", () => actions.isolate(id), "Alone");
    isolate.setAttribute("aria-pressed", String(isolated));
    this.holder.replaceChildren(
      make("header", {}, make("h2", {}, dot, instance.name, make("span", { className: "number" }, ` ${id}`)),
        iconButton("close", "Close the card", actions.close)),
      this.strip(instance),
      make("p", { className: "facts" }, ...facts(instance)),
      ...guesses(instance),
      ...this.links("Part of", instance.part_of === null ? [] : [{ text: "", id: instance.part_of }], model),
      ...this.links("Parts", instance.parts.map((part) => ({ text: "", id: part })), model),
      ...this.links("Where", model.linksOf(id).filter(({ text }) => !/part/.test(text)), model),
      make("div", { className: "actions" },
        iconButton("fly", "Fly there", () => actions.fly(id), "Fly there"), isolate),
      actions.editTools(instance) ?? "",
    );
    this.holder.hidden = false;
    this.holder.scrollTop = 0;
  }

  private strip(instance: Instance): HTMLElement {
    const strip = make("div", { className: "crops" });
    const files = this.pictures.crops(instance.id);
    for (const [place, address] of files.entries()) {
      strip.append(make("img", { src: address, alt: `${instance.name} ${instance.id}, view ${place + 1}` }));
    }
    if (!files.length) {
      const drawn = make("div", { className: "drawn" });
      this.pictures.into(drawn, instance.id);
      strip.append(drawn);
    }
    return strip;
  }

  private links(title: string, links: Link[], model: MapModel): HTMLElement[] {
    const known = links.filter(({ id }) => model.byId.has(id));
    if (!known.length) return [];
    const link = (id: number): HTMLElement =>
      make("button", { type: "button", className: "link", onclick: () => this.actions.choose(id) }, model.label(id));
    const items = [...new Set(known.map(({ text }) => text))].map((text) => {
      const others = known.filter((each) => each.text === text).map(({ id }) => link(id));
      const relation = text && make("span", { className: "relation" }, text);
      return make("li", { className: text ? "" : "plain-links" }, relation, make("span", { className: "linked" }, ...others));
    });
    return [make("h3", {}, title), make("ul", { className: "links" }, ...items)];
  }
}

function facts(instance: Instance): HTMLElement[] {
  const { n_frames, first_frame, last_frame } = instance;
  const frames = `${n_frames} ${n_frames === 1 ? "frame" : "frames"} (${first_frame}–${last_frame})`;
  const pairs: [string, string][] = [
    ["Size", sizeText(instance.extent_m)],
    ["Seen in", frames],
    ["Confidence", `${Math.round(100 * instance.score)} %`],
  ];
  if (instance.kind === "stuff") pairs.unshift(["Kind", "surface"]);
  if (instance.edited) pairs.push(["Edited", "by hand"]);
  return pairs.map(([name, value]) => make("span", {}, make("span", { className: "fact" }, name), value));
}

function guesses(instance: Instance): HTMLElement[] {
  if (!instance.class_guesses.length) return [];
  const rows = instance.class_guesses.map(({ name, probability }) => {
    const bar = make("span", { className: "bar" });
    bar.style.width = `${Math.max(1, 100 * probability)}%`;
    const percent = probability < 0.01 ? "< 1 %" : `${Math.round(100 * probability)} %`;
    return make("li", {}, make("span", {}, name), make("span", { className: "percent" }, percent),
      make("span", { className: "bar-holder" }, bar));
  });
  return [make("h3", {}, "It may be"), make("ul", { className: "guesses" }, ...rows)];
}
