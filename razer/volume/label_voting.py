"""Label voting: each voxel at the observed surface takes one vote a frame for its instance (RAZER section IV-F)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import cv2
import numpy as np
import torch

from razer.arrays import BoolArray, Int32Array
from razer.detection.lifting import Detection
from razer.detection.observed_surface import ObservedSurface
from razer.volume.voxel_map import VoxelMap

# Masks are shrunk and their borders unsure: so near to one, at 640x480, no voxel loses a vote.
BORDER_PIXELS = 8


def vote(
    voxels: VoxelMap,
    surface: ObservedSurface,
    detections: Sequence[Detection],
    owners: Int32Array,
    withdraw: bool = True,
    spared: Mapping[int, Sequence[int]] | None = None,
) -> Int32Array:
    """Each voxel at the observed surface takes one vote for the owner of the pixel it projects to.

    Args:
        voxels: The volume to vote in.
        surface: The observed surface of the frame.
        detections: Its N detections; where they overlap, the one with fewer pixels is voted for.
        owners: The track (N,) of each.
        spared: By detection the tracks whose voxels do not vote for its owner.
        withdraw: Whether voxels lose a vote for each instance that the frame shows, but elsewhere: what a mask spilled
            over in one view, and a table's votes for the book on it, are taken back in others.

    Returns:
        The strided id image (h, w), 0 = nobody.
    """
    owners = np.array(voxels.resolve(torch.from_numpy(owners)).tolist(), np.int32)
    ids = id_image(surface, _without(voxels, surface, detections, spared or {}), owners)
    # A further layer before and behind costs three times as much and labels 0.1 % more vertices rightly.
    row, column, z, on_image = surface.cell_pixels
    near = on_image & (np.abs(surface.depth[row, column] - z) <= 2 * voxels.settings.voxel_size_m)
    may_withdraw = near & _far_from_borders(ids)[row, column] if withdraw else np.zeros_like(near)
    voxels.vote(surface.cells, np.where(near, ids[row, column], 0), np.unique(ids[ids > 0]), may_withdraw)
    return ids


def _without(
    voxels: VoxelMap, surface: ObservedSurface, detections: Sequence[Detection], spared: Mapping[int, Sequence[int]]
) -> list[Detection]:
    """The detections, without readings in voxels of tracks that are spared."""
    result = list(detections)
    if spared:
        labels = np.array(voxels.labels_at(surface.cells).tolist(), np.int32)
        for i, tracks in spared.items():
            pixels = detections[i].pixels
            result[i] = replace(detections[i], pixels=pixels[~np.isin(labels[surface.pixel_cell[pixels]], tracks)])
    return result


def _far_from_borders(ids: Int32Array) -> BoolArray:
    """Which pixels (h, w) have only their own id around them."""
    size = 2 * round(BORDER_PIXELS * len(ids) / 480) + 1
    kernel, exact = np.ones((size, size), np.uint8), ids.astype(np.float32)
    same: BoolArray = cv2.dilate(exact, kernel) == cv2.erode(exact, kernel)
    return same


def id_image(surface: ObservedSurface, detections: Sequence[Detection], owners: Int32Array) -> Int32Array:
    """The strided image (h, w) of the owners (N,) of N detections, 0 = nobody."""
    ids = np.zeros(surface.depth.shape, np.int32)
    # Small things stand on or before large ones, and all things before stuff: they are painted last. Of equal ones the
    # one that comes last in the order of content (`razer.detection.perception.in_order_of_content`).
    for i in sorted(range(len(detections)), key=lambda i: (not detections[i].is_stuff, -len(detections[i].pixels))):
        pixels = detections[i].pixels
        ids[surface.rows[pixels], surface.columns[pixels]] = owners[i]
    return ids
