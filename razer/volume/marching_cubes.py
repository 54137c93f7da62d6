"""Marching cubes over pages of blocks, part by part, with what each part needs of the blocks around it.

A part is copied into a grid of its own, with those voxels of the next blocks that its cubes reach: their lower faces.
No cube has all corners among these alone, and so each is marched in one part, as it would be in one grid of all.
"""

from __future__ import annotations

import numpy as np
import open3d as o3d
import open3d.core as o3c
import torch
from numpy.typing import NDArray
from torch import Tensor

from razer.arrays import Float32Array, Int32Array, Uint8Array
from razer.config import VoxelSettings
from razer.detection.observed_surface import BLOCK
from razer.volume.blocks.block_pages import BlockPages, shared
from razer.volume.surface_evidence import is_observed_enough

PART_BLOCKS = 512  # some 85 KB each, and as much again while they are marched
_NEXT = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)][1:], np.int32)
_ATTRIBUTES = ("tsdf", "weight", "color")

Triangles = tuple[Float32Array, Uint8Array, Int32Array]
"""Vertices (V, 3) metres, their colours (V, 3), and triangles (T, 3)."""


def marching_cubes(pages: BlockPages, settings: VoxelSettings, block_keys: Int32Array | None = None) -> Triangles:
    """The zero crossing among voxels that were observed enough, of all cubes or of those whose lowest corner lies in
    one of some blocks (B, 3) that the pages have. Vertices of edges on the border of two parts come once for each; no
    order is kept."""
    keys = pages.all()[0] if block_keys is None else block_keys
    none = np.zeros((0, 3))
    parts = [(none.astype(np.float32), none.astype(np.uint8), none.astype(np.int32))]
    for start in range(0, len(keys), PART_BLOCKS):
        grid = _grid_of(pages, keys[start : start + PART_BLOCKS], settings)
        mesh = grid.extract_triangle_mesh(0.5)
        if "positions" in mesh.vertex:
            columns = mesh.vertex.positions, mesh.vertex.colors, mesh.triangle.indices
            positions, colors, triangles = (column.cpu().numpy() for column in columns)
            n_before = sum(len(part[0]) for part in parts)
            parts.append((positions + 0.0, color_bytes(colors), triangles.astype(np.int32) + n_before))  # no -0.0
    vertices, colors, triangles = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    return vertices, colors, triangles


def color_bytes(colors: NDArray) -> Uint8Array:
    """Colours from 0 to 1 as bytes."""
    return np.clip(np.rint(colors * 255), 0, 255).astype(np.uint8)


def _grid_of(pages: BlockPages, keys: Int32Array, settings: VoxelSettings) -> o3d.t.geometry.VoxelBlockGrid:
    """A grid of the blocks (B, 3), and of what their cubes reach of others; voxels that were not observed enough weigh
    nothing."""
    around = np.unique((keys[:, None] + _NEXT).reshape(-1, 3), axis=0)
    rows, rows_around = pages.find(keys), pages.find(around)
    others = torch.nonzero((rows_around >= 0) & ~torch.isin(rows_around, rows)).squeeze(1)
    grid = o3d.t.geometry.VoxelBlockGrid(
        _ATTRIBUTES,
        (o3c.float32,) * len(_ATTRIBUTES),
        tuple(o3c.SizeVector([n]) for n in (1, 1, 3)),
        settings.voxel_size_m,
        BLOCK,
        len(keys) + len(others),
        pages.device,
    )
    _copy(pages, rows, keys, grid, settings)
    if len(others):
        weight, places = _copy(pages, rows_around[others], around[others.tolist()], grid, settings)
        weight[places[:, None], torch.nonzero(~_on_lower_face(places.device)).T] = -1.0
    return grid


def _copy(
    pages: BlockPages, rows: Tensor, keys: Int32Array, grid: o3d.t.geometry.VoxelBlockGrid, settings: VoxelSettings
) -> tuple[Tensor, Tensor]:
    """Copy blocks of given rows (B,) and keys (B, 3) into a grid; returns its weights (rows, 4096, 1), and where they
    lie in it (B,)."""
    hashmap, block_keys = grid.hashmap(), o3c.Tensor(keys).to(pages.device)
    hashmap.activate(block_keys)
    places = shared(hashmap.find(block_keys)[0].to(o3c.int64))
    for name in _ATTRIBUTES:
        pages.copy_blocks(rows, name, shared(grid.attribute(name)).flatten(1, 3), places)
    weight = shared(grid.attribute("weight")).flatten(1, 3)
    weight[places] = weight[places] * is_observed_enough(weight[places, :, 0], settings)[..., None]
    return weight, places


def _on_lower_face(device: torch.device) -> Tensor:
    """Which of the 4096 voxels of a block lie where one of its coordinates is 0."""
    x = torch.arange(BLOCK, device=device) == 0
    return (x[:, None, None] | x[:, None] | x).flatten()
