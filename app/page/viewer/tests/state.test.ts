import assert from "node:assert/strict";
import { test } from "node:test";
import type { Instance, LoadedMap } from "../src/map_types";
import { fromHash, toHash } from "../src/state/hash";
import { MapModel, sizeText } from "../src/state/map_model";
import { classColor, confidenceColor, instanceColor } from "../src/state/palette";
import type { State } from "../src/state/store";

const STATE: State = {
  mode: 1.25, selected: 4, hovered: null, isolated: 4, search: "a red chair & co", hits: null, minScore: 0.5,
  minSize_cm: 20, tool: "none", walking: false, playing: false, hidesCeiling: false, showsOther: true, theme: "dark",
};

function instance(id: number, name: string, vertices: number): Instance {
  return {
    id, name, probability: 0.9, class_guesses: [], kind: "thing", score: 1, center_m: [0, 0, 0], extent_m: [1, 1, 1],
    orientation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], n_frames: 1, first_frame: 0, last_frame: 0, parts: [], part_of: null,
    crops: 0, edited: false, vertices,
  };
}

function model(): MapModel {
  const header = {
    instances: [instance(1, "chair", 10), instance(2, "coffee table", 90), instance(12, "cup", 5)],
    relations: [{ subject: 12, relation: "on", object: 2 }, { subject: 12, relation: "on", object: 99 }],
    kinds: {
      chair: ["seat", "furniture", "sit on"], "coffee table": ["furniture", "put a cup on", "sit at"], cup: ["tableware"],
    },
  };
  return new MapModel({ header, crops: new Map() } as unknown as LoadedMap);
}

test("the state comes back from its link", () => {
  const view = { position: [1, 2, -3.5] as [number, number, number], target: [0, 0.25, 0] as [number, number, number] };
  const { view: seen, state } = fromHash(`#${toHash(STATE, view)}`);
  assert.deepEqual(seen, view);
  const { mode, selected, isolated, search, minScore, minSize_cm, hidesCeiling, showsOther, theme } = STATE;
  assert.deepEqual(state, { mode, selected, isolated, search, minScore, minSize_cm, hidesCeiling, showsOther, theme });
});

test("a damaged link is no state", () => {
  assert.deepEqual(fromHash("#v=1,2,x,4,5,6&m=much&t=pink&s="), { view: null, state: {} });
  assert.equal(fromHash("#v=1,2,3,4,5,1e9").view, null);
});

test("search goes by names, kinds, numbers and plurals", () => {
  const found = (text: string): number[] => [...model().matching(text)];
  assert.deepEqual(found("furniture"), [1, 2]);
  assert.deepEqual(found("the chairs"), [1]);
  assert.deepEqual(found("tab"), [2]);
  assert.deepEqual(found("seats"), [1]);
  assert.deepEqual(found("something to sit on"), [1]);
  assert.deepEqual(found("cup"), [12]);
  assert.deepEqual(found("tableware"), [12]);
  assert.deepEqual(found("#12"), [12]);
  assert.deepEqual(found("coffee cup"), []);
  assert.deepEqual(found("  "), []);
});

test("relations read from both ends; those with unknown things are left out", () => {
  assert.deepEqual(model().linksOf(12), [{ text: "on", id: 2 }]);
  assert.deepEqual(model().linksOf(2), [{ text: "carries", id: 12 }]);
});

test("the largest things have the first colours, and no two of ten the same", () => {
  const [first] = model().colors(model().byId.get(2)!);
  assert.deepEqual(first, instanceColor(0, false));
  assert.equal(new Set(Array.from({ length: 30 }, (_, i) => classColor(i, false).join())).size, 30);
});

test("confidence goes from dark to light", () => {
  const brightness = [0, 0.25, 0.5, 0.75, 1].map((share) => confidenceColor(share).reduce((a, b) => a + b));
  assert.deepEqual(brightness, [...brightness].sort((a, b) => a - b));
});

test("sizes are whole centimetres, the longest first", () => {
  assert.equal(sizeText([0.451, 1.204, 0.6]), "120 × 60 × 45 cm");
});
