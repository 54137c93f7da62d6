// The loaded map: its instances, their colours and relations, and the search by name and kind.
import type { Instance, LoadedMap, MapHeader } from "../map_types";
import { classColor, confidenceColor, instanceColor, type Rgb } from "./palette";

export interface Link {
  text: string; // such as "on", or "carries"
  id: number;
}

// How a relation reads from its other end.
const TURNED: Record<string, string> = {
  on: "carries",
  in: "holds",
  under: "covers",
  against: "touched by",
  "next to": "next to",
  "part of": "has part",
};

export class MapModel {
  readonly byId: Map<number, Instance>;
  readonly header: MapHeader;
  private readonly classPlace = new Map<string, number>();
  private readonly instancePlace = new Map<number, number>();
  private readonly links = new Map<number, Link[]>();

  constructor(readonly loaded: LoadedMap) {
    this.header = loaded.header;
    const { instances, relations } = loaded.header;
    this.byId = new Map(instances.map((instance) => [instance.id, instance]));
    // What covers most of the map comes first, and has the colours that differ most.
    const bySize = [...instances].sort((a, b) => b.vertices - a.vertices || a.id - b.id);
    for (const kind of ["thing", "stuff"]) {
      const members = bySize.filter((instance) => instance.kind === kind);
      members.forEach(({ id }, place) => this.instancePlace.set(id, place));
      const names = [...new Set(members.map(({ name }) => name))];
      names.forEach((name, place) => this.classPlace.has(name) || this.classPlace.set(name, place));
    }
    for (const { subject, relation, object } of relations) {
      this.link(subject, relation, object);
      this.link(object, TURNED[relation] ?? relation, subject);
    }
  }

  get instances(): Instance[] {
    return this.header.instances;
  }

  get names(): string[] {
    return [...this.classPlace.keys()].sort();
  }

  get maxId(): number {
    return Math.max(0, ...this.byId.keys());
  }

  label(id: number): string {
    return `${this.byId.get(id)?.name ?? "thing"} ${id}`;
  }

  linksOf(id: number): Link[] {
    return this.links.get(id) ?? [];
  }

  colors(instance: Instance): [Rgb, Rgb, Rgb] {
    const isStuff = instance.kind === "stuff";
    return [
      instanceColor(this.instancePlace.get(instance.id) ?? 0, isStuff),
      classColor(this.classPlace.get(instance.name) ?? 0, isStuff),
      confidenceColor(instance.probability ?? instance.score),
    ];
  }

  /** The colour that an instance has at a place of the slider. */
  colorAt(instance: Instance, mode: number): Rgb {
    return this.colors(instance)[mode < 1.5 ? 0 : mode < 2.5 ? 1 : 2];
  }

  /** Instances whose name or number begins with each of the words, or of a kind or purpose that is called so. */
  matching(text: string): Set<number> {
    const words = wordsOf(text);
    const found = new Set<number>();
    if (!words.length) return found;
    for (const instance of this.instances) {
      const own = [...wordsOf(instance.name), String(instance.id), `#${instance.id}`];
      const kinds = this.header.kinds[instance.name] ?? [];
      const isNamed = words.every((word) => own.some((known) => begins(known, word)));
      if (isNamed || kinds.some((kind) => isSame(wordsOf(kind), words))) found.add(instance.id);
    }
    return found;
  }

  private link(from: number, text: string, id: number): void {
    if (!this.byId.has(from) || !this.byId.has(id)) return;
    this.links.set(from, [...(this.links.get(from) ?? []), { text, id }]);
  }
}

const FILLERS = new Set(["a", "an", "the", "some", "something", "to"]);

function wordsOf(text: string): string[] {
  return text.toLowerCase().split(/[^\p{L}\p{N}#]+/u).filter((word) => word && !FILLERS.has(word));
}

function begins(known: string, word: string): boolean {
  return known.startsWith(word) || known === singular(word);
}

/** Whether words say the same: "sit on" is not "sit at", nor is a cup what cups are put on. */
function isSame(known: string[], words: string[]): boolean {
  return known.length === words.length && known.every((word, i) => word === words[i] || word === singular(words[i]));
}

function singular(word: string): string {
  return word.length > 3 && word.endsWith("s") ? word.slice(0, -1) : word;
}

/** Edges of a box in words: 120 x 60 x 45 cm. */
export function sizeText(extent_m: number[]): string {
  return `${[...extent_m].sort((a, b) => b - a).map((edge) => Math.round(100 * edge)).join(" × ")} cm`;
}
