"""Label overlap: what lies under detections and masks, counted by hand."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from razer.detection.lifting import Lifted
from razer.tracking.label_overlap import LabelOverlap, nested_masks
from razer.volume.voxel_map import VoxelMap
from tests.support.scenes import COARSE, axis_box, cells_at, detection, frame_of

UNIT_CUBE = axis_box((0, 0, 0), (1, 1, 1))


def test_visible_iou_by_hand() -> None:
    overlap = LabelOverlap({(0, 1): 6, (0, 2): 2, (1, 2): 3}, {0: 8, 1: 3}, {1: 10, 2: 5}, {})
    # 2 of 8 cells are what is known beforehand.
    assert overlap.visible_iou(0, 1) == pytest.approx((6 + 2) / (8 + 10 - 6 + 8))
    assert overlap.visible_iou(0, 2) == pytest.approx((2 + 2) / (8 + 5 - 2 + 8))
    assert overlap.visible_iou(1, 1) == 0
    assert overlap.visible_iou(5, 9) == 0
    assert overlap.owned_share(0, 1, 12) == pytest.approx(0.5)


def test_few_cells_in_view_prove_little() -> None:
    ious = [LabelOverlap({(0, 1): cells}, {0: cells}, {1: cells}, {}).visible_iou(0, 1) for cells in (1, 4, 16, 1000)]
    assert ious == pytest.approx([3 / 9, 6 / 12, 18 / 24, 1002 / 1008])


def test_evidence_counts_labels_under_detections_and_masks_by_hand() -> None:
    """A strip of ten cells: four of track 1, four of track 2, two of nobody."""
    voxels = VoxelMap(COARSE)
    voxels.integrate(frame_of(np.full((120, 160), 1.5)))
    voxels.admit(2)
    cells = cells_at([[x, 0, 37] for x in range(10)])
    voxels.vote(cells, np.array([1, 1, 1, 1, 2, 2, 2, 2, 0, 0], np.int32))
    found = (detection(UNIT_CUBE, cells=[2, 3, 4]), detection(UNIT_CUBE, cells=[5, 6, 7, 8, 9], mask=1))
    member_mask, member_cell = np.array([0, 0, 0, 0, 1, 1, 1, 1, 1, 1]), np.arange(10)
    lifted = Lifted(found, member_mask.astype(np.int32), member_cell.astype(np.int32))
    overlap = LabelOverlap.gather(voxels, cells, lifted)
    assert overlap.shared == {(0, 1): 2, (0, 2): 1, (1, 2): 3}
    assert dict(overlap.labelled) == {0: 3, 1: 3}
    assert overlap.visible == {1: 4, 2: 4}
    assert overlap.in_mask == {(0, 1): 4, (1, 2): 4}
    voxels.replace(2, 1)
    fused = LabelOverlap.gather(voxels, cells, lifted)
    assert fused.visible == {1: 8}
    assert fused.visible_iou(0, 1) == pytest.approx((3 + 2) / (8 + 8))


def test_evidence_of_a_frame_without_masks() -> None:
    voxels = VoxelMap(COARSE)
    voxels.integrate(frame_of(np.full((120, 160), 1.5)))
    voxels.admit(1)
    cells = cells_at([[x, 0, 37] for x in range(10)])
    voxels.vote(cells, np.ones(10, np.int32))
    nothing = np.zeros(0, np.int32)
    overlap = LabelOverlap.gather(voxels, cells, Lifted((), nothing, nothing))
    assert overlap.visible == {1: 10}
    assert overlap.shared == overlap.in_mask == {}
    assert_allclose(overlap.visible_iou(0, 1), 0)


def test_of_what_shares_no_cell_nothing_is_owned() -> None:
    overlap = LabelOverlap({(0, 1): 30}, {0: 40}, {1: 50, 2: 20}, {})
    assert overlap.owned_share(0, 1, 60) == 0.5
    assert overlap.owned_share(0, 2, 60) == 0
    assert overlap.owned_share(3, 1, 60) == 0


@pytest.mark.parametrize(
    ("inner", "outer", "names", "nested"),
    [
        (range(10), range(30), {}, True),
        (range(10), range(10), {}, False),  # the same twice is no part of itself
        (range(10), range(1, 30), {}, True),  # nine of ten
        (range(10), range(2, 30), {}, False),
        (range(10), range(20, 40), {}, False),
        (range(10), range(30), {0: "cup", 1: "table"}, False),
        (range(10), range(30), {0: "chair", 1: "chair"}, True),
        (range(10), range(30), {0: None, 1: "chair"}, True),
    ],
)
def test_a_mask_within_another_is_a_part_of_it(
    inner: range, outer: range, names: dict[int, str | None], nested: bool
) -> None:
    for masks in ((inner, outer), (outer, inner)):
        mask, cell = (
            np.array(column, np.int32) for column in zip(*((m, c) for m in (0, 1) for c in masks[m]), strict=True)
        )
        here = masks[0] is inner
        named = names if here else {1 - m: name for m, name in names.items()}
        assert nested_masks(mask, cell, named) == ({(0, 1) if here else (1, 0)} if nested else frozenset())


def test_a_frame_without_masks_has_none_nested() -> None:
    nothing = np.zeros(0, np.int32)
    assert nested_masks(nothing, nothing, {}) == frozenset()
