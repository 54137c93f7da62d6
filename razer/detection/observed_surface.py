"""Observed surface of a frame: the cells of the voxel lattice its depth readings fall in, computed once for all masks.

A cell is a voxel sample: integer coordinates times the voxel size is its position. Cells are addressed as
Open3D's VoxelBlockGrid does, by a block of 16^3 voxels and a place within it, so that they can be looked up
in the map directly; their order is that of their coordinates and never that of a hash map.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import numpy as np

from razer.arrays import BoolArray, Float32Array, Float64Array, IndexArray, Int32Array
from razer.errors import UnusableFrame
from razer.frame import Frame
from razer.geometry import back_project, inverse, project, transform_points

BLOCK = 16
BLOCK_VOXELS = BLOCK**3


@dataclass(frozen=True)
class Cells:
    """C lattice cells: block_keys (B, 3) int32 sorted; block (C,) row of block_keys; local (C,) place within
    the block (x fastest). Sorted by (block, local), each cell once."""

    voxel_size_m: float
    block_keys: Int32Array
    block: Int32Array
    local: Int32Array

    def __len__(self) -> int:
        return len(self.block)

    def __getstate__(self) -> dict[str, Any]:
        """Without what follows from it: cells travel between processes."""
        return {part.name: getattr(self, part.name) for part in fields(self)}

    @cached_property
    def coordinates(self) -> Int32Array:
        """Integer lattice coordinates (C, 3)."""
        place = np.stack([self.local % BLOCK, self.local // BLOCK % BLOCK, self.local // BLOCK**2], axis=1)
        return self.block_keys[self.block] * BLOCK + place

    @cached_property
    def points(self) -> Float64Array:
        """World positions (C, 3) in metres."""
        return self.coordinates.astype(np.float64) * self.voxel_size_m


def cells_of(coordinates: Int32Array, voxel_size_m: float) -> tuple[Cells, Int32Array]:
    """The distinct cells among (N, 3) lattice coordinates, and for each of the N the row of its cell."""
    if len(coordinates) == 0:
        empty = np.zeros(0, np.int32)
        return Cells(voxel_size_m, np.zeros((0, 3), np.int32), empty, empty), empty
    blocks = coordinates >> 4
    low = blocks.min(axis=0)
    shape = (blocks.max(axis=0) - low + 1).astype(np.intp)
    x, y, z = (blocks - low).T
    flat = (x * shape[1] + y) * shape[2] + z
    is_present = np.zeros(int(np.prod(shape)), bool)
    is_present[flat] = True
    present = np.flatnonzero(is_present)
    rank = np.zeros(len(is_present), np.intp)
    rank[present] = np.arange(len(present))
    x, y, z = (coordinates & (BLOCK - 1)).T
    address = rank.take(flat) * BLOCK_VOXELS + (x + BLOCK * (y + BLOCK * z))
    is_occupied = np.zeros(len(present) * BLOCK_VOXELS, bool)
    is_occupied[address] = True
    addresses = np.flatnonzero(is_occupied).astype(np.int32)
    row = np.zeros(len(is_occupied), np.int32)
    row[addresses] = np.arange(len(addresses), dtype=np.int32)
    keys = np.stack(np.unravel_index(present, tuple(shape)), axis=1).astype(np.int32) + low.astype(np.int32)
    return Cells(voxel_size_m, keys, addresses // BLOCK_VOXELS, addresses % BLOCK_VOXELS), row.take(address)


@dataclass(frozen=True)
class ObservedSurface:
    """The depth readings of one frame on every `stride`-th pixel, and the cells they fall in.

    depth (h, w) float32, 0 = none or out of range; matrix (3, 3) of the strided image; rows (P,) and
    columns (P,) of its P readings; pixel_cell (P,) row of each one's cell.
    """

    stride: int
    depth: Float32Array
    matrix: Float64Array
    world_from_camera: Float64Array
    rows: Int32Array
    columns: Int32Array
    cells: Cells
    pixel_cell: Int32Array
    _within: dict[float, Int32Array] = field(default_factory=dict, init=False, repr=False, compare=False)

    @cached_property
    def extent(self) -> tuple[int, int, int, int]:
        """First and last row, first and last column of its readings: a registered depth image ends before the colour
        image does."""
        rows, columns = self.rows, self.columns
        return int(rows.min()), int(rows.max()), int(columns.min()), int(columns.max())

    @classmethod
    def of(cls, frame: Frame, voxel_size_m: float, depth_min_m: float, depth_max_m: float) -> ObservedSurface:
        """Read a posed frame just densely enough that neighbouring readings share or touch cells.

        Args:
            frame: With a pose.
            voxel_size_m: Edge of a lattice cell, metres.
            depth_min_m: Nearer readings are ignored, metres.
            depth_max_m: Farther readings are ignored, metres.

        Raises:
            UnusableFrame: The frame has no pose, or none of its readings is in range.
        """
        stride = max(1, int(voxel_size_m * frame.intrinsics.fx / depth_max_m))
        depth = np.ascontiguousarray(frame.depth[::stride, ::stride])
        depth = np.where((depth >= depth_min_m) & (depth <= depth_max_m), depth, np.float32(0))
        matrix = frame.intrinsics.matrix
        matrix[:2] /= stride
        rows, columns = np.nonzero(depth)
        if len(rows) == 0:
            raise UnusableFrame(f"no depth reading between {depth_min_m:g} and {depth_max_m:g} m")
        world = transform_points(frame.pose, back_project(columns, rows, depth[depth > 0], matrix))
        world /= voxel_size_m
        cells, pixel_cell = cells_of(np.rint(world, out=world).astype(np.int32), voxel_size_m)
        narrow = (rows.astype(np.int32), columns.astype(np.int32))  # half the bytes to send to another process
        return cls(stride, depth, matrix, frame.pose, *narrow, cells, pixel_cell)

    def prepared(self, distance_m: float) -> ObservedSurface:
        """The same, with everything computed beforehand that a map needs whose truncation distance is `distance_m`, so
        that another process can do it."""
        self.blocks_within(distance_m)
        _ = self.cell_pixels
        return self

    @cached_property
    def cell_pixels(self) -> tuple[Int32Array, Int32Array, Float64Array, BoolArray]:
        """`pixels_of` the cells."""
        return self.pixels_of(self.cells.points)

    def _rays(self) -> Float64Array:
        """Unit viewing rays (C, 3) to the cells."""
        rays = self.cells.points - self.world_from_camera[:3, 3]
        return rays / np.maximum(np.linalg.norm(rays, axis=1, keepdims=True), 1e-9)

    def readings_in(self, masks: BoolArray) -> tuple[IndexArray, Int32Array]:
        """(mask, reading) of every reading inside each of (N, h, w) strided masks, ordered by mask."""
        reading = np.full(self.depth.size, -1, np.int32)
        reading[self.rows * self.depth.shape[1] + self.columns] = np.arange(len(self.rows), dtype=np.int32)
        flat = np.flatnonzero(masks & (self.depth > 0))
        mask = flat // self.depth.size
        return mask, reading[flat - mask * self.depth.size]

    def pixels_of(self, points: Float64Array) -> tuple[Int32Array, Int32Array, Float64Array, BoolArray]:
        """Row, column and depth of world points (N, 3) on the strided image, and which of them fall on it."""
        u, v, z = project(transform_points(inverse(self.world_from_camera), points), self.matrix)
        with np.errstate(invalid="ignore"):
            height, width = self.depth.shape
            on_image = (u > -0.5) & (u < width - 0.5) & (v > -0.5) & (v < height - 0.5)
            row, column = np.rint(v).astype(np.int32), np.rint(u).astype(np.int32)
        return np.where(on_image, row, 0), np.where(on_image, column, 0), z, on_image

    def blocks_within(self, distance_m: float) -> Int32Array:
        """Sorted keys (M, 3) of the blocks within a distance of the surface along the viewing rays."""
        if distance_m not in self._within:
            self._within[distance_m] = self._blocks_within(distance_m)
        return self._within[distance_m]

    def _blocks_within(self, distance_m: float) -> Int32Array:
        reach, rays = distance_m / self.cells.voxel_size_m, self._rays()
        # Steps of less than half a block do not jump over the corner of one that matters.
        steps = np.linspace(-reach, reach, 2 * int(np.ceil(reach / (BLOCK / 2))) + 1)
        keys = [np.floor((self.cells.coordinates + rays * step) / BLOCK).astype(np.int32) for step in steps]
        return cells_of(np.concatenate(keys) * BLOCK, self.cells.voxel_size_m)[0].block_keys
