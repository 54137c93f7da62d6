// Buttons over the map, the slider of colours, and the player of the camera path.
import type { State, Store } from "../state/store";
import { byId, icon, iconButton, make } from "./elements";

export interface ToolActions {
  home: () => void;
  picture: () => void;
  play: () => void;
  seek: (share: number) => void;
  compare: (() => void) | null;
  hasPath: boolean;
  hasCeiling: boolean;
  help: () => void;
}

const MODES = ["Colour", "Instance", "Class", "Confidence"];

export class Toolbar {
  private readonly slider = byId<HTMLInputElement>("mode");
  private readonly buttons = new Map<keyof State | "ruler", HTMLButtonElement>();
  private readonly names: HTMLButtonElement[];
  private scrubber: HTMLInputElement | null = null;

  constructor(private readonly store: Store) {
    this.names = MODES.map((name, place) => {
      const onclick = (): void => this.glide(place);
      return make("button", { type: "button", onclick, title: `${name} (key ${place + 1})` }, name);
    });
    byId("mode-names").append(...this.names);
    this.slider.oninput = () => store.set({ mode: Number(this.slider.value) });
    this.slider.onchange = () => this.settle();
  }

  /** Buttons for what this map has. */
  build(actions: ToolActions): void {
    const { store } = this;
    const list = iconButton("list", "Show or hide the list", () => document.body.classList.toggle("list-open"));
    list.id = "list-button";
    const toggle = (key: "walking" | "hidesCeiling" | "showsOther", name: string, label: string): HTMLButtonElement => {
      const button = iconButton(name, label, () => store.set({ [key]: !store.state[key] }));
      this.buttons.set(key, button);
      return button;
    };
    const ruler = iconButton("ruler", "Measure a distance (R)", () =>
      store.set({ tool: store.state.tool === "ruler" ? "none" : "ruler" }));
    this.buttons.set("ruler", ruler);
    byId("tools").replaceChildren(...([
      list,
      iconButton("home", "Whole map (H)", actions.home),
      toggle("walking", "walk", "Walk about (W)"),
      ruler,
      actions.hasPath && iconButton("play", "Play the camera's path (P)", actions.play),
      actions.hasCeiling && toggle("hidesCeiling", "ceiling", "Hide the ceiling from above (C)"),
      actions.compare && toggle("showsOther", "compare", "Given or estimated poses (B)"),
      iconButton("camera", "Save a picture (S)", actions.picture),
      iconButton("theme", "Light or dark (T)", () =>
        store.set({ theme: store.state.theme === "dark" ? "light" : "dark" })),
      iconButton("help", "Keys (?)", actions.help),
    ].filter(Boolean) as HTMLElement[]));
    this.player(actions);
    this.mark();
  }

  mark(): void {
    const { state } = this.store;
    this.slider.value = String(state.mode);
    this.slider.setAttribute("aria-valuetext", MODES[Math.round(state.mode)]);
    this.names.forEach((name, place) => name.setAttribute("aria-pressed", String(Math.abs(place - state.mode) < 0.5)));
    for (const [key, button] of this.buttons) {
      button.setAttribute("aria-pressed", String(key === "ruler" ? state.tool === "ruler" : Boolean(state[key])));
    }
    byId("player").hidden = !state.playing;
  }

  played(share: number | null, isPlaying: boolean): void {
    if (!this.scrubber) return;
    if (share !== null) this.scrubber.value = String(share);
    const button = byId("player").querySelector("button")!;
    button.replaceChildren(icon(isPlaying ? "pause" : "play"));
    button.setAttribute("aria-label", isPlaying ? "Pause" : "Play");
  }

  glide(mode: number): void {
    const from = this.store.state.mode;
    const start = performance.now();
    const step = (now: number): void => {
      const share = Math.min((now - start) / 350, 1);
      this.store.set({ mode: share === 1 ? mode : from + (mode - from) * share * share * (3 - 2 * share) });
      if (share < 1) requestAnimationFrame(step);
    };
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) this.store.set({ mode });
    else requestAnimationFrame(step);
  }

  /** Stops that are nearly met are met. */
  private settle(): void {
    const nearest = Math.round(this.store.state.mode);
    if (Math.abs(nearest - this.store.state.mode) < 0.12) this.store.set({ mode: nearest });
  }

  private player(actions: ToolActions): void {
    const properties = { type: "range", min: "0", max: "1", step: "0.001", value: "0", "aria-label": "Place on the path" };
    this.scrubber = make("input", properties);
    this.scrubber.oninput = () => actions.seek(Number(this.scrubber!.value));
    byId("player").replaceChildren(
      iconButton("pause", "Pause", actions.play), this.scrubber,
      iconButton("close", "End the ride", () => this.store.set({ playing: false })));
  }
}

const KEYS: [string, string][] = [
  ["/", "search"], ["1 2 3 4", "colour, instance, class, confidence"], ["H", "whole map"], ["F", "fly to what is chosen"],
  ["I", "show it alone"], ["W", "walk about: W A S D or arrows, drag to look, click on the floor to go there"],
  ["R", "ruler: click two points"], ["P", "play the camera's path"], ["C", "ceiling"], ["B", "given or estimated poses"],
  ["S", "save a picture"], ["T", "light or dark"], ["Esc", "let go"],
];

export function showHelp(): void {
  const dialog = byId<HTMLDialogElement>("help");
  const rows = KEYS.flatMap(([key, text]) => [make("dt", {}, key), make("dd", {}, text)]);
  dialog.replaceChildren(make("h2", {}, "Keys"), make("dl", {}, ...rows),
    make("p", {}, "Drag turns, right drag moves, scrolling comes nearer; a click on a thing tells about it."),
    make("button", { type: "button", className: "plain", onclick: () => dialog.close() }, "Close"));
  dialog.showModal();
}
