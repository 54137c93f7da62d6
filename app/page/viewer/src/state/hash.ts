// The state in the address's hash, so that a link shows what its sender saw.
import type { View } from "../scene/navigation";
import type { State, Theme } from "./store";

export interface Linked {
  view: View | null;
  state: Partial<State>;
}

export function toHash(state: State, view: View): string {
  const numbers = [...view.position, ...view.target].map((value) => value.toFixed(2)).join(",");
  const parts: [string, string | null][] = [
    ["v", numbers],
    ["m", state.mode ? state.mode.toFixed(2).replace(/\.?0+$/, "") : null],
    ["s", state.selected === null ? null : String(state.selected)],
    ["i", state.isolated === null ? null : String(state.isolated)],
    ["q", state.search || null],
    ["a", state.minScore ? state.minScore.toFixed(2) : null],
    ["z", state.minSize_cm ? String(state.minSize_cm) : null],
    ["w", state.walking ? "1" : null],
    ["c", state.hidesCeiling ? null : "0"],
    ["b", state.showsOther ? "1" : null],
    ["t", state.theme],
  ];
  return parts.filter(([, value]) => value !== null).map(([key, value]) => `${key}=${encodeURIComponent(value!)}`).join("&");
}

export function fromHash(hash: string): Linked {
  const values = new URLSearchParams(hash.replace(/^#/, ""));
  const state: Partial<State> = {};
  const number = (key: string): number | null => {
    const value = Number(values.get(key));
    return values.get(key) && Number.isFinite(value) ? value : null;
  };
  const mode = number("m");
  if (mode !== null) state.mode = Math.min(Math.max(mode, 0), 3);
  if (number("s") !== null) state.selected = number("s");
  if (number("i") !== null) state.isolated = number("i");
  if (values.get("q")) state.search = values.get("q")!.slice(0, 200);
  if (number("a") !== null) state.minScore = Math.min(Math.max(number("a")!, 0), 1);
  if (number("z") !== null) state.minSize_cm = Math.max(number("z")!, 0);
  if (values.get("w") === "1") state.walking = true;
  if (values.get("c") === "0") state.hidesCeiling = false;
  if (values.get("b") === "1") state.showsOther = true;
  const theme = values.get("t");
  if (theme === "light" || theme === "dark") state.theme = theme as Theme;
  return { view: viewOf(values.get("v")), state };
}

function viewOf(text: string | null): View | null {
  const numbers = (text ?? "").split(",").map(Number);
  if (numbers.length !== 6 || !numbers.every((value) => Number.isFinite(value) && Math.abs(value) < 1e4)) return null;
  return { position: numbers.slice(0, 3) as View["position"], target: numbers.slice(3) as View["target"] };
}

export function keepInAddress(hash: string): void {
  try {
    history.replaceState(null, "", `#${hash}`);
  } catch {
    // A page that a browser shows without an address of its own has no hash either.
  }
}
