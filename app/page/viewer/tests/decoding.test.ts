import assert from "node:assert/strict";
import { test } from "node:test";
import { decodeBlocks } from "../src/decoding/blocks";
import { bit, joinPlanes, parsePacket, unzigzag } from "../src/decoding/packet";
import { normals, surfaceOf } from "../src/decoding/surface";

test("byte planes are joined low bytes first", () => {
  assert.deepEqual([...joinPlanes(Uint8Array.of(1, 2, 0, 1), 2)], [1, 258]);
  assert.deepEqual([...joinPlanes(new Uint8Array(), 0)], []);
});

test("zigzag numbers get their signs back", () => {
  assert.deepEqual([...unzigzag(Int32Array.of(0, 1, 2, 3, 4))], [0, -1, 1, -2, 2]);
});

test("bits are read from the low end", () => {
  assert.deepEqual([0, 1, 2, 8].map((i) => bit(Uint8Array.of(0b101, 1), i)), [1, 0, 1, 1]);
});

test("anything but a packet is refused", () => {
  assert.throws(() => parsePacket(Uint8Array.of(1, 2, 3, 4, 5, 6, 7, 8)), /no data of a map/);
});

test("normals point to the side from which corners go round against the clock", () => {
  const triangle = { positions: Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0), triangles: Uint32Array.of(0, 1, 2) };
  assert.deepEqual([...normals(triangle).subarray(0, 3)], [0, 0, 127]);
});

test("triangles stand by instance, and end with a corner of theirs", () => {
  const surface = surfaceOf({
    positions: new Float32Array(15),
    colors: new Uint8Array(20),
    ids: Float32Array.of(7, 7, 3, 3, 3),
    triangles: Uint32Array.of(0, 1, 2, 2, 3, 4, 2, 0, 1),
  });
  assert.deepEqual(surface.ranges, [[3, 0, 3], [7, 3, 6]]);
  const ids = [...surface.triangles].map((vertex) => surface.ids[vertex]);
  assert.equal(ids[2], 3);
  assert.deepEqual([ids[5], ids[8]], [7, 7]);
});

test("blocks that are gone come without a surface", () => {
  const bytes = (array: ArrayBufferView): Uint8Array => new Uint8Array(array.buffer);
  const sections = new Map([
    ["positions", bytes(Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0))],
    ["colors", Uint8Array.of(1, 2, 3, 4, 5, 6, 7, 8, 9)],
    ["instances", bytes(Int32Array.of(5, 5, 5))],
    ["triangles", bytes(Uint32Array.of(0, 1, 2))],
  ]);
  const blocks = [
    { key: [0, 0, -1] as [number, number, number], vertices: 0, triangles: 0 },
    { key: [0, 0, 0] as [number, number, number], vertices: 3, triangles: 1 },
  ];
  const changed = decodeBlocks({ header: { format: 1, revision: 4, epoch: 0, blocks }, sections });
  assert.equal(changed.revision, 4);
  assert.deepEqual(changed.blocks.map(({ key, surface }) => [key, surface?.ranges ?? null]),
    [["0,0,-1", null], ["0,0,0", [[5, 0, 3]]]]);
  assert.deepEqual([...changed.blocks[1].surface!.colors.subarray(0, 8)], [1, 2, 3, 255, 4, 5, 6, 255]);
});
