"""Support-based pruning, the paper's way: tracks go that were unmatched in the frustum, or filled little of their box,
for k frames in a row, unless their semantic confidence is high (RAZER sections IV-C and IV-F)."""

from __future__ import annotations

from collections.abc import Mapping, Set

import numpy as np
import torch

from razer.boxes.oriented_box import OrientedBox
from razer.config import MaintenanceSettings
from razer.detection.observed_surface import ObservedSurface
from razer.volume.blocks.block_pages import BLOCKS_AT_ONCE
from razer.volume.voxel_map import VoxelMap


class SupportPruning:
    """For how many frames in a row each track was unmatched in view, and for how many its support was low."""

    def __init__(self, settings: MaintenanceSettings) -> None:
        self._settings = settings
        self._unmatched: dict[int, int] = {}
        self._unsupported: dict[int, int] = {}
        self._n_frames = 0  # since support was last measured

    def count_frame(self, surface: ObservedSurface, boxes: Mapping[int, OrientedBox], matched: Set[int]) -> None:
        """Take in a frame: the boxes of all live tracks, and the ids of those that it matched."""
        self._n_frames += 1
        if not boxes:
            return
        _, _, z, on_image = surface.pixels_of(np.stack([box.center for box in boxes.values()]))
        in_frustum = on_image & (z > 0) & (z <= surface.depth.max())
        for track_id, is_in_view in zip(boxes, in_frustum.tolist(), strict=True):
            if track_id in matched:
                self._unmatched[track_id] = 0
            elif is_in_view:
                self._unmatched[track_id] = self._unmatched.get(track_id, 0) + 1

    def doomed(self, support: Mapping[int, float], confidences: Mapping[int, float]) -> list[int]:
        """The tracks to prune: their support r_i is as given since the last call, confidences are their max c_j."""
        s = self._settings
        n_low = {i: self._unsupported.get(i, 0) + self._n_frames for i, r in support.items() if r < s.min_support}
        self._unsupported, self._n_frames = n_low, 0
        self._unmatched = {i: n for i, n in self._unmatched.items() if i in support}
        late = {i for counts in (self._unmatched, n_low) for i, n in counts.items() if n >= s.max_misses}
        return sorted(i for i in late if confidences[i] <= s.keep_confidence)


def support_ratios(voxels: VoxelMap, boxes: Mapping[int, OrientedBox]) -> dict[int, float]:
    """The support r_i of tracks by id (RAZER eq. 15): the voxels that bear their label over the volume of their box.

    The paper divides a number by a volume, whose unit it leaves open. Here voxels count with the volume that they fill,
    so that r_i has no unit; a box flatter than a voxel counts as one voxel thick.
    """
    size_m = voxels.settings.voxel_size_m
    counts = torch.zeros(voxels.newest_id + 1, dtype=torch.int64, device=voxels.torch_device)
    for rows in voxels.pages.all()[1].split(BLOCKS_AT_ONCE):
        labels = voxels.pages.blocks(rows, "label")
        counts += torch.bincount(voxels.resolve(labels[labels > 0]).long(), minlength=len(counts))
    n_voxels = counts[list(boxes)].tolist()
    volumes_m3 = (float(np.prod(np.maximum(box.extent, size_m))) for box in boxes.values())
    return {i: n * size_m**3 / volume_m3 for i, n, volume_m3 in zip(boxes, n_voxels, volumes_m3, strict=True)}
