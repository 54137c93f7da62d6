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
    points = voxels.positions(addresses).cpu().numpy().astype(np.float64)
    slot_ids, slot_counts = voxels.attribute("ids"), voxels.attribute("counts")
    ids, counts = slot_ids[addresses].T.contiguous(), slot_counts[addresses].T.contiguous()
    for track_id in np.unique(owners).tolist():
        inside = torch.from_numpy(np.flatnonzero(boxes[track_id].contains(points))).to(addresses.device)
        votes = torch.full_like(inside, track_id, dtype=ids.dtype)
        ids[:, inside], counts[:, inside] = label_histogram.cast(ids[:, inside], counts[:, inside], votes)
    slot_ids[addresses], slot_counts[addresses] = ids.T.contiguous(), counts.T.contiguous()
    voxels.relabel(addresses)
    return id_image(surface, detections, owners)


def _truncation_band(voxels: VoxelMap, surface: ObservedSurface) -> Tensor:
    """Addresses (n,) of the voxels within the truncation distance of the surface that the frame shows."""
    distance_m = voxels.settings.truncation_m

    def was_near(weight: Tensor, tsdf: Tensor) -> Tensor:
        return ((weight > 0) & (tsdf < 1))[..., 0]

    near = voxels.select(voxels.rows_of(surface.blocks_within(distance_m)), was_near, "weight", "tsdf")
    row, column, z, on_image = surface.pixels_of(voxels.positions(near).cpu().numpy().astype(np.float64))
    depth = surface.depth[row, column]
    in_band = on_image & (z > 0) & (depth > 0) & (np.abs(depth - z) <= distance_m)
    return near[torch.from_numpy(np.flatnonzero(in_band)).to(near.device)]
