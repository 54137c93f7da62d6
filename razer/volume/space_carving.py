"""Space carving: voxels observed as free space lose weight and votes, so that a thing carried away leaves no ghost
(docs/method.md step 10)."""

from __future__ import annotations

import cv2
import numpy as np
import torch
from torch import Tensor

from razer.arrays import BoolArray, Float32Array, Int32Array
from razer.detection.observed_surface import BLOCK, ObservedSurface
from razer.geometry import inverse, transform_points
from razer.volume.blocks.block_pages import BLOCKS_AT_ONCE
from razer.volume.voxel_map import SURFACE_VOXELS, VoxelMap

# Free space is claimed only where every reading within this many strided pixels lies behind the voxel: colour
# and depth edges, pose errors of a pixel and the shadows beside thin parts must not eat surfaces.
EDGE_PIXELS = 2
KEPT_SHARE = 0.125  # of weight and votes, after a pass


def carve(voxels: VoxelMap, surface: ObservedSurface) -> None:
    """Cut down weight and votes of surface voxels that stand in front of the frame's depth, by more than the truncation
    distance; voxels of less than one observation become empty."""
    nearest = nearest_readings(surface.depth)
    rows = _rows_in_view(voxels, surface)
    surface_tsdf = SURFACE_VOXELS / voxels.settings.truncation_voxels

    def may_be_surface(weight: Tensor, tsdf: Tensor, label: Tensor) -> Tensor:
        return ((weight > 0) & ((tsdf <= surface_tsdf) | (label > 0)))[..., 0]

    for part in rows.split(BLOCKS_AT_ONCE):
        near = voxels.pages.select(part, may_be_surface, "weight", "tsdf", "label")
        free = near[_is_free(voxels.pages.positions(near), surface, nearest, voxels.settings.truncation_m)]
        _clear(voxels, free, surface_tsdf)


def nearest_readings(depth: Float32Array) -> Float32Array:
    """The smallest depth around each pixel (h, w), 0 where any of its neighbours has none."""
    size = 2 * EDGE_PIXELS + 1
    return cv2.erode(depth, np.ones((size, size), np.uint8))


def _rows_in_view(voxels: VoxelMap, surface: ObservedSurface) -> Tensor:
    """Rows (B,) of the blocks that may reach into the viewing frustum; those out of its bounds are not looked at."""
    size_m = BLOCK * voxels.settings.voxel_size_m
    height, width = surface.depth.shape
    corners = np.array([[0, 0], [width, 0], [0, height], [width, height]]) - surface.matrix[:2, 2]
    rays = np.c_[corners / surface.matrix[[0, 1], [0, 1]], np.ones(4)]
    corners_m = np.r_[np.zeros((1, 3)), rays * (surface.depth.max() + size_m)]
    frustum = transform_points(surface.world_from_camera, corners_m) / size_m
    # `_in_view` takes centres within an edge of it along each axis of the camera, that is sqrt(3) along those here.
    low, high = frustum.min(axis=0) - 1.8 - 0.5, frustum.max(axis=0) + 1.8 - 0.5
    keys, rows = voxels.pages.within(np.floor(low).astype(np.int32), np.ceil(high).astype(np.int32))
    return rows[torch.from_numpy(np.flatnonzero(_in_view(keys, voxels, surface))).to(rows.device)]


def _in_view(keys: Int32Array, voxels: VoxelMap, surface: ObservedSurface) -> BoolArray:
    """Which blocks may reach into the viewing frustum."""
    size_m = BLOCK * voxels.settings.voxel_size_m
    camera = transform_points(inverse(surface.world_from_camera), (keys + 0.5) * size_m)
    height, width = surface.depth.shape
    focal, centre = surface.matrix[[0, 1], [0, 1]], surface.matrix[:2, 2]
    z = np.maximum(camera[:, 2:], 0.0)
    low, high = -centre / focal * z - size_m, (np.array([width, height]) - centre) / focal * z + size_m
    inside = ((camera[:, :2] >= low) & (camera[:, :2] <= high)).all(axis=1)
    return inside & (camera[:, 2] > -size_m) & (camera[:, 2] < surface.depth.max() + size_m)


def _is_free(points: Tensor, surface: ObservedSurface, nearest: Float32Array, margin_m: float) -> Tensor:
    camera = torch.from_numpy(inverse(surface.world_from_camera)).to(points)
    local = points @ camera[:3, :3].T + camera[:3, 3]
    z = local[:, 2].clamp(min=1e-3)
    matrix, depth = surface.matrix, torch.from_numpy(nearest).to(points.device)
    column = (local[:, 0] / z * matrix[0, 0] + matrix[0, 2]).round().long()
    row = (local[:, 1] / z * matrix[1, 1] + matrix[1, 2]).round().long()
    height, width = depth.shape
    on_image = (local[:, 2] > 0) & (row >= 0) & (row < height) & (column >= 0) & (column < width)
    return on_image & (depth[row.clamp(0, height - 1), column.clamp(0, width - 1)] - local[:, 2] > margin_m)


def _clear(voxels: VoxelMap, free: Tensor, surface_tsdf: float) -> None:
    weight, tsdf, counts = voxels.pages.read(free, "weight", "tsdf", "counts")
    # What lies well outside a surface is free rightly, and the mesh needs its distances.
    is_inside = tsdf <= surface_tsdf
    weight = torch.where(is_inside, weight * KEPT_SHARE, weight)
    voxels.pages.write(free, weight=weight, counts=counts // int(1 / KEPT_SHARE))
    empty = free[(is_inside & (weight < 1))[:, 0]]
    names = ("weight", "tsdf", "ids", "counts", "color")
    nothing = voxels.pages.read(empty, *names)
    voxels.pages.write(empty, **{name: column.zero_() for name, column in zip(names, nothing, strict=True)})
    voxels.relabel(free)
