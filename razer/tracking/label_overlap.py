"""Label overlap of a frame with the map: which labels lie under each detection and each mask, and how much of each
track the frame shows."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from razer.arrays import Int32Array
from razer.detection.lifting import Lifted
from razer.detection.observed_surface import Cells
from razer.volume.voxel_map import VoxelMap

# What is known of an overlap before any cell is seen: a few cells in view prove nothing.
PRIOR_IOU = 0.25
PRIOR_CELLS = 8
NESTED = 0.9  # share of a mask's cells within another that makes it a part of that one


@dataclass(frozen=True)
class LabelOverlap:
    """Counts of observed cells: `shared` {(detection, track): cells}, `labelled` {detection: cells with any
    label}, `visible` {track: cells in the frame}, `in_mask` {(mask, track): cells}; `nested`, (inner, outer) pairs of
    masks; `stuff`, the masks of stuff."""

    shared: Mapping[tuple[int, int], int]
    labelled: Mapping[int, int]
    visible: Mapping[int, int]
    in_mask: Mapping[tuple[int, int], int]
    nested: frozenset[tuple[int, int]] = frozenset()
    stuff: frozenset[int] = frozenset()

    @classmethod
    def gather(cls, voxels: VoxelMap, cells: Cells, lifted: Lifted) -> LabelOverlap:
        """Look up the labels of all cells of a frame once and count them."""
        detections = lifted.detections
        labels = voxels.labels_at(cells)
        all_cells = np.arange(len(cells), dtype=np.int32)
        in_frame = voxels.count_labels(labels, np.zeros_like(all_cells), all_cells)
        in_mask = voxels.count_labels(labels, lifted.member_mask, lifted.member_cell)
        empty = np.zeros(0, np.int32)
        groups = [empty, *(np.full(d.n_cells, i, np.int32) for i, d in enumerate(detections))]
        members = [empty, *(d.cells for d in detections)]
        shared = voxels.count_labels(labels, np.concatenate(groups), np.concatenate(members))
        labelled: dict[int, int] = defaultdict(int)
        for (detection, _), n in shared.items():
            labelled[detection] += n
        nested = nested_masks(lifted.member_mask, lifted.member_cell, {d.mask: d.class_name for d in detections})
        visible = {track: n for (_, track), n in in_frame.items()}
        stuff = frozenset(d.mask for d in detections if d.is_stuff)
        return cls(shared, labelled, visible, in_mask, nested, stuff)

    def visible_iou(self, detection: int, track: int) -> float:
        """IoU of a detection with the track's voxels as this frame sees them. Cells without a label count
        for neither side: they are new, and no track can own them yet."""
        shared = self.shared.get((detection, track), 0)
        union = self.labelled.get(detection, 0) + self.visible.get(track, 0) - shared
        return (shared + PRIOR_IOU * PRIOR_CELLS) / (union + PRIOR_CELLS) if shared else 0.0

    def owned_share(self, detection: int, track: int, n_cells: int) -> float:
        """Share of a detection's cells that bear the track's label."""
        return self.shared.get((detection, track), 0) / n_cells


def nested_masks(mask: Int32Array, cell: Int32Array, class_of: Mapping[int, str | None]) -> frozenset[tuple[int, int]]:
    """Pairs (inner, outer) of masks of which one lies in the other, as a seat does in its chair; but not where both
    have names and these differ, as those of a cup and the table on which it stands.

    Args:
        mask: Of M pairs of a mask and a cell it covers, (M,).
        cell: Of each pair, (M,).
        class_of: The names of masks, where they have any.
    """
    if len(mask) == 0:
        return frozenset()
    covers = csr_array((np.ones(len(mask), np.int32), (mask, cell)))
    common = (covers @ covers.T).tocoo()
    size = np.bincount(mask)
    inner, outer = common.coords
    is_nested = (size[inner] < size[outer]) & (common.data >= NESTED * size[inner])
    pairs = zip(inner[is_nested].tolist(), outer[is_nested].tolist(), strict=True)
    return frozenset(pair for pair in pairs if len({class_of.get(m) for m in pair} - {None}) < 2)
