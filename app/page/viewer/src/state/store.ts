// What the page shows at the moment, and who wants to know when that changes.
export type Theme = "light" | "dark";
export type Tool = "none" | "ruler" | "lasso" | "plane" | "pick";

export interface State {
  mode: number; // 0 colour, 1 instance, 2 class, 3 confidence, and between
  selected: number | null;
  hovered: number | null;
  isolated: number | null;
  search: string;
  hits: Map<number, number> | null; // probability by id; null: nothing was asked
  minScore: number;
  minSize_cm: number;
  tool: Tool;
  walking: boolean;
  playing: boolean;
  hidesCeiling: boolean;
  showsOther: boolean;
  theme: Theme;
}

type Listener = (state: State, changed: Set<keyof State>) => void;

export class Store {
  private readonly listeners: Listener[] = [];

  constructor(private current: State) {}

  get state(): Readonly<State> {
    return this.current;
  }

  set(patch: Partial<State>): void {
    const keys = (Object.keys(patch) as (keyof State)[]).filter((key) => patch[key] !== this.current[key]);
    if (!keys.length) return;
    this.current = { ...this.current, ...patch };
    for (const listener of this.listeners) listener(this.current, new Set(keys));
  }

  subscribe(listener: Listener): void {
    this.listeners.push(listener);
  }
}

export function initialState(): State {
  return {
    mode: 0,
    selected: null,
    hovered: null,
    isolated: null,
    search: "",
    hits: null,
    minScore: 0,
    minSize_cm: 0,
    tool: "none",
    walking: false,
    playing: false,
    hidesCeiling: true,
    showsOther: false,
    theme: matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light",
  };
}
