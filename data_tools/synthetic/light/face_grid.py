"""Grids of light samples over the faces of a world, packed into one image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from data_tools.synthetic.shapes.solids import quad_normals
from razer.arrays import Float32Array, Float64Array, Int64Array, IntArray

SPACING_M = 0.07
_MOST_NODES = 250_000
_MANY_FACES = 60_000
_IMAGE_WIDTH = 4096
_MARGIN = 1
_INSET = 0.04  # share of the way to a face's middle: corners touch other solids
_LIFT_M = 0.002


@dataclass(frozen=True, slots=True)
class FaceGrid:
    """Samples on F planar faces, a grid of columns x rows (F, 2) on each.

    gradient (F, 2, 3) and origin (F, 2) take a world point to (column, row) of its face's grid; first (F,) is the
    number of a face's first node, nodes running along columns first; place (F, 2) is where in the image of shape
    (height, width) its node (0, 0) lies, as x and y.
    """

    normals: Float64Array
    gradient: Float64Array
    origin: Float64Array
    counts: Int64Array
    first: Int64Array
    place: Int64Array
    shape: tuple[int, int]

    @classmethod
    def over(cls, quads: Float64Array) -> FaceGrid:
        """A grid over each of the quads (F, 4, 3), coarser where a world is large."""
        normals = quad_normals(quads)
        axes = _axes(quads, normals)
        flat = np.einsum("fck,fak->fca", quads, axes)
        low, size = flat.min(axis=1), np.ptp(flat, axis=1)
        counts = _counts(size)
        steps = (counts - 1) / np.maximum(size, 1e-6)
        gradient = steps[:, :, None] * axes
        nodes = counts.prod(axis=1)
        place, shape = _packed(counts)
        return cls(normals, gradient, -steps * low, counts, np.cumsum(nodes) - nodes, place, shape)

    @property
    def face(self) -> Int64Array:
        """The face (N,) of each node."""
        return np.repeat(np.arange(len(self.counts)), self.counts.prod(axis=1))

    def cell(self) -> Int64Array:
        """Column and row (N, 2) of each node."""
        number = np.arange(self.counts.prod(axis=1).sum()) - self.first[self.face]
        columns = self.counts[self.face, 0]
        return np.column_stack([number % columns, number // columns])

    def points(self, quads: Float64Array) -> Float64Array:
        """Where the nodes (N, 3) are: on their quad, a little inside its edges and above it."""
        face = self.face
        # The axes are orthogonal, so that each gradient over its square is the step along it.
        step = self.gradient / np.maximum((self.gradient**2).sum(axis=2, keepdims=True), 1e-12)
        middle = quads.mean(axis=1)
        offset = self.cell() - np.einsum("fak,fk->fa", self.gradient, middle)[face] - self.origin[face]
        points = middle[face] + np.einsum("na,nak->nk", offset, step[face])
        for corner in range(4):
            points = _within(points, quads[face, corner], quads[face, (corner + 1) % 4], self.normals[face])
        points += _INSET * (middle[face] - points)
        return points + _LIFT_M * self.normals[face]

    def nearest_node(self, face: IntArray, points: Float32Array) -> Int64Array:
        """The number of the node of a face (P,) nearest to a point on it (P, 3)."""
        node, stride = self.first[face], np.ones(len(face), np.int64)
        for axis in (0, 1):
            along = (self.gradient[:, axis].astype(np.float32)[face] * points).sum(axis=1)
            cell = np.rint(along + self.origin[:, axis].astype(np.float32)[face]).astype(np.int64)
            node += stride * np.clip(cell, 0, self.counts[face, axis] - 1)
            stride = self.counts[face, 0]
        return node

    def image(self, values: Float32Array) -> Float32Array:
        """Values (N, C) of the nodes as an image (H, W, C), each grid with its rim repeated round it."""
        image = np.zeros((*self.shape, values.shape[1]), np.float32)
        cell, corner = self.cell(), self.place[self.face]
        last = self.counts[self.face] - 1
        for dx in (-1, 0, 1):
            for dy in (-1, 0, 1):
                # The rim goes outwards; inner nodes land on their own place.
                out = np.where(cell == np.where(np.array([dx, dy]) < 0, 0, last), (dx, dy), 0)
                x, y = (corner + cell + out).T
                image[y, x] = values
        return image


def _axes(quads: Float64Array, normals: Float64Array) -> Float64Array:
    """Two unit vectors (F, 2, 3) in each face's plane, the first along its longest edge."""
    edges = np.roll(quads, -1, axis=1) - quads
    longest = np.linalg.norm(edges, axis=2).argmax(axis=1)
    along = edges[np.arange(len(quads)), longest]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return np.stack([along, np.cross(normals, along)], axis=1)


def _counts(size: Float64Array) -> Int64Array:
    """Columns and rows (F, 2) of grids over rectangles (F, 2), metres: at least two of each, or one where there are
    very many faces."""
    spacing, least = SPACING_M, 2 if len(size) <= _MANY_FACES else 1
    while True:
        counts = np.maximum(np.ceil(size / spacing).astype(np.int64) + 1, least)
        if least == 1:
            counts[size < spacing / 2] = 1
        if counts.prod(axis=1).sum() <= max(_MOST_NODES, (least + 1) * len(size)):
            return counts
        spacing *= 1.25


def _packed(counts: Int64Array) -> tuple[Int64Array, tuple[int, int]]:
    """Where grids lie (F, 2) in an image, row by row from the highest to the lowest, and its shape."""
    sizes = counts + 2 * _MARGIN
    width = max(_IMAGE_WIDTH, int(sizes[:, 0].max()))
    place = np.empty_like(counts)
    x = top = high = 0
    for number in np.argsort(-sizes[:, 1], kind="stable"):
        wide, tall = (int(value) for value in sizes[number])
        if x + wide > width:
            x, top, high = 0, top + high, 0
        place[number] = x + _MARGIN, top + _MARGIN
        x, high = x + wide, max(high, tall)
    return place, (top + high, width)


def _within(points: Float64Array, start: Float64Array, end: Float64Array, normals: Float64Array) -> Float64Array:
    """Points (N, 3) moved to the inner side of an edge of a face, against the clock round its normal."""
    inwards = np.cross(normals, end - start)
    inwards /= np.maximum(np.linalg.norm(inwards, axis=1, keepdims=True), 1e-12)
    beyond = np.minimum(np.einsum("nk,nk->n", points - start, inwards), 0)
    return points - beyond[:, None] * inwards
