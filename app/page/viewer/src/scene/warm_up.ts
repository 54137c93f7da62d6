// Draws everything once while the map opens: a shader that is made later waits for all frames before it.
import { Vector3 } from "three";
import type { Instance } from "../map_types";
import type { BoxMark, Ruler } from "./marks";
import type { Outlines } from "./outlines";
import type { Picker } from "./picker";
import type { Thumbnails } from "./thumbnails";
import type { Viewport } from "./viewport";

export interface Marked {
  viewport: Viewport;
  outlines: Outlines;
  box: BoxMark;
  ruler: Ruler;
  picker: Picker;
  thumbnails: Thumbnails;
}

export async function warmUp(marked: Marked, first: Instance | undefined): Promise<void> {
  if (!first) return;
  const { viewport, outlines, box, ruler, picker, thumbnails } = marked;
  const ids = [first.id];
  outlines.show({ hovered: ids, selected: ids, hits: ids });
  box.show(first);
  for (const point of [new Vector3(), new Vector3(0, 1, 0)]) ruler.add(point);
  viewport.render();
  outlines.show({ hovered: [], selected: [], hits: [] });
  box.show(null);
  ruler.clear();
  await picker.at(0, 0);
  await thumbnails.draw(first.id);
}
