"""Label voting by boxes, the paper's way: all voxels within a track's box and the truncation distance of the observed
surface take its vote (RAZER sections IV-A, IV-F and IV-H)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import torch
from torch import Tensor

from razer.arrays import Int32Array
from razer.boxes.oriented_box import OrientedBox
from razer.detection.lifting import Detection
from razer.detection.observed_surface import ObservedSurface
from razer.geometry import inverse
from razer.volume import label_histogram
from razer.volume.label_voting import id_image
from razer.volume.voxel_map import VoxelMap


def vote_in_boxes(
    voxels: VoxelMap,
    surface: ObservedSurface,
    detections: Sequence[Detection],
    owners: Int32Array,
    boxes: Mapping[int, OrientedBox],
) -> Int32Array:
    """One vote for each track of a frame, by each voxel of the band of its surface that lies within the track's box.

    Args:
        voxels: The volume to vote in.
        surface: The observed surface of the frame.
        detections: Its N detections.
        owners: The track (N,) of each.
        boxes: Of these tracks, by id; where boxes overlap, voxels vote for several.

    Returns:
        The strided image (h, w) of the masks' owners, 0 = nobody.
    """
    addresses = _truncation_band(voxels, surface)
    voxels.relabel(addresses)  # so that the histograms name live instances
    points = voxels.pages.positions(addresses)
    ids, counts = (column.T.contiguous() for column in voxels.pages.read(addresses, "ids", "counts"))
    for track_id in np.unique(owners).tolist():
        inside = torch.nonzero(_in_box(points, boxes[track_id])).squeeze(1)
        votes = torch.full_like(inside, track_id, dtype=ids.dtype)
        ids[:, inside], counts[:, inside] = label_histogram.cast(ids[:, inside], counts[:, inside], votes)
    voxels.pages.write(addresses, ids=ids.T.contiguous(), counts=counts.T.contiguous())
    voxels.relabel(addresses)
    return id_image(surface, detections, owners)


def _in_box(points: Tensor, box: OrientedBox) -> Tensor:
    """Which of (n, 3) points lie in a box."""
    center, rotation, extent = (torch.from_numpy(part).to(points) for part in (box.center, box.rotation, box.extent))
    return (((points - center) @ rotation).abs() <= extent / 2).all(dim=1)


def _truncation_band(voxels: VoxelMap, surface: ObservedSurface) -> Tensor:
    """Addresses (n,) of the voxels within the truncation distance of the surface that the frame shows."""
    distance_m = voxels.settings.truncation_m

    def was_near(weight: Tensor, tsdf: Tensor) -> Tensor:
        return ((weight > 0) & (tsdf < 1))[..., 0]

    near = voxels.pages.select(voxels.rows_of(surface.blocks_within(distance_m)), was_near, "weight", "tsdf")
    depth, z = _depths(voxels.pages.positions(near), surface)
    return near[(z > 0) & (depth > 0) & ((depth - z).abs() <= distance_m)]


def _depths(points: Tensor, surface: ObservedSurface) -> tuple[Tensor, Tensor]:
    """The depth that the frame shows where points (n, 3) project to, 0 = none, and their own depths (n,)."""
    camera = torch.from_numpy(inverse(surface.world_from_camera)).to(points)
    local = points @ camera[:3, :3].T + camera[:3, 3]
    z = local[:, 2]
    u, v = (local[:, axis] / z * surface.matrix[axis, axis] + surface.matrix[axis, 2] for axis in (0, 1))
    height, width = surface.depth.shape
    on_image = (z > 0) & (u > -0.5) & (u < width - 0.5) & (v > -0.5) & (v < height - 0.5)
    column, row = (torch.where(on_image, pixel, 0).round().long() for pixel in (u, v))
    depth = torch.from_numpy(surface.depth).to(points)[row, column]
    return torch.where(on_image, depth, 0), z
