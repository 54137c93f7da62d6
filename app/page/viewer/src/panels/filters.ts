// Filters on confidence and size.
import type { MapModel } from "../state/map_model";
import type { Store } from "../state/store";
import { byId } from "./elements";

export class Filters {
  private readonly score = byId<HTMLInputElement>("score");
  private readonly size = byId<HTMLInputElement>("size");

  constructor(private readonly store: Store) {
    this.score.oninput = () => store.set({ minScore: Number(this.score.value) });
    this.size.oninput = () => store.set({ minSize_cm: Number(this.size.value) });
  }

  mark(): void {
    const { minScore, minSize_cm } = this.store.state;
    this.score.value = String(minScore);
    this.size.value = String(minSize_cm);
    byId("score-text").textContent = `${Math.round(100 * minScore)} %`;
    byId("size-text").textContent = `${minSize_cm} cm`;
    if (minScore || minSize_cm) byId<HTMLDetailsElement>("filters").open = true;
  }
}

/** The instances that pass the filters. */
export function passing(model: MapModel, minScore: number, minSize_cm: number): Set<number> {
  const kept = model.instances.filter(
    ({ score, extent_m }) => score >= minScore && 100 * Math.max(...extent_m) >= minSize_cm,
  );
  return new Set(kept.map(({ id }) => id));
}
