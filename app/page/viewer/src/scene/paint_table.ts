// Writes into the table of ids what the state says of each instance.
import type { MapModel } from "../state/map_model";
import { NOBODY } from "../state/palette";
import type { State } from "../state/store";
import type { IdTable } from "./id_table";

/** `shown` are the instances that pass the filters. */
export function paintTable(table: IdTable, model: MapModel, state: State, shown: Set<number>): void {
  const { hits, isolated, hovered } = state;
  table.reach(model.maxId);
  table.setColors(0, NOBODY, NOBODY, NOBODY);
  table.setShown(0, { visible: isolated === null, hit: 0, lit: false });
  for (const instance of model.instances) {
    const { id } = instance;
    const visible = isolated === null ? shown.has(id) : id === isolated;
    table.setColors(id, ...model.colors(instance));
    table.setShown(id, { visible, hit: hits?.get(id) ?? 0, lit: id === hovered });
  }
}
