"""Exact overlap of oriented boxes, against closed forms, Monte Carlo, and half-space intersection."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection

from razer.boxes.iou import box_containment, box_iou, shared_volumes
from razer.boxes.oriented_box import OrientedBox
from tests.support.scenes import axis_box, moved, pose, random_box


def halfspaces(box: OrientedBox) -> np.ndarray:
    """(6, 4) rows n, b with n . x + b <= 0 inside."""
    normals = np.concatenate([box.rotation.T, -box.rotation.T])
    return np.column_stack([normals, -normals @ box.center - np.tile(box.extent / 2, 2)])


def slow_shared_volume(a: OrientedBox, b: OrientedBox) -> float:
    """Volume of the intersection by its largest inscribed sphere and the hull of its vertices."""
    planes = np.concatenate([halfspaces(a), halfspaces(b)])
    found = linprog(
        [0, 0, 0, -1], A_ub=np.column_stack([planes[:, :3], np.ones(12)]), b_ub=-planes[:, 3], bounds=(None, None)
    )
    if found.x[3] <= 1e-9:
        return 0.0
    return float(ConvexHull(HalfspaceIntersection(planes, found.x[:3]).intersections).volume)


def random_pairs(seed: int, count: int) -> tuple[list[OrientedBox], list[OrientedBox]]:
    rng = np.random.default_rng(seed)
    return [random_box(rng) for _ in range(count)], [random_box(rng) for _ in range(count)]


def test_volume_is_that_of_the_half_space_intersection() -> None:
    first, second = random_pairs(1, 60)
    expected = [slow_shared_volume(a, b) for a, b in zip(first, second, strict=True)]
    assert 20 < np.count_nonzero(expected) < 60  # both kinds are tried
    assert_allclose(shared_volumes(first, second), expected, atol=1e-8)


def test_volume_agrees_with_monte_carlo() -> None:
    first, second = random_pairs(2, 20)
    rng = np.random.default_rng(3)
    local = rng.uniform(-0.5, 0.5, (50_000, 3))
    for a, b, volume in zip(first, second, shared_volumes(first, second), strict=True):
        share = b.contains(a.center + (local * a.extent) @ a.rotation.T).mean()
        sigma = np.sqrt(max(share * (1 - share), 1e-5) / len(local))
        assert volume / a.volume == pytest.approx(share, abs=4.5 * sigma)


def aligned_shared_volume(a: OrientedBox, b: OrientedBox) -> float:
    low = np.maximum(a.center - a.extent / 2, b.center - b.extent / 2)
    high = np.minimum(a.center + a.extent / 2, b.center + b.extent / 2)
    return float(np.prod(np.maximum(high - low, 0)))


# Centres and edges on a grid make coplanar faces and shared edges, the hard cases of clipping, the common ones.
GRID_BOX = st.builds(
    lambda c, e: axis_box(np.array(c) / 2, np.array(e, float)),
    st.tuples(*[st.integers(-3, 3)] * 3),
    st.tuples(*[st.integers(1, 3)] * 3),
)


@given(first=GRID_BOX, second=GRID_BOX, turn=st.sampled_from([(0, 0, 0), (90, 0, 0), (0, 180, 90), (30, 40, 50)]))
@settings(deadline=None, max_examples=100)
def test_aligned_boxes_follow_the_closed_form_in_any_common_frame(
    first: OrientedBox, second: OrientedBox, turn: tuple
) -> None:
    expected = aligned_shared_volume(first, second)
    world = pose((3, -1, 2), turn)
    a, b = moved(first, world), moved(second, world)
    assert shared_volumes([a], [b])[0] == pytest.approx(expected, abs=1e-6)
    assert box_iou([a], [b])[0] == pytest.approx(expected / (a.volume + b.volume - expected), abs=1e-6)
    assert box_containment([a], [b])[0] == pytest.approx(expected / min(a.volume, b.volume), abs=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_a_box_is_itself(seed: int) -> None:
    box = random_box(np.random.default_rng(seed))
    # The same body, described by other axes.
    turned = OrientedBox(box.center, box.rotation[:, [1, 2, 0]], box.extent[[1, 2, 0]])
    assert_allclose(box_iou([box, box], [box, turned]), 1.0, atol=1e-7)


def test_disjoint_and_touching_boxes_share_nothing() -> None:
    unit = axis_box((0, 0, 0), (1, 1, 1))
    others = [axis_box(c, (1, 1, 1)) for c in [(3, 0, 0), (1, 0, 0), (1, 1, 0), (1, 1, 1), (0, -1, 0.3)]]
    assert_allclose(shared_volumes([unit] * 5, others), 0.0, atol=1e-7)
    assert_allclose(box_iou([unit] * 5, others), 0.0, atol=1e-7)


@pytest.mark.parametrize("seed", range(5))
def test_a_box_inside_another(seed: int) -> None:
    rng = np.random.default_rng(seed)
    small, large = random_box(rng, 0.0), axis_box((0.1, 0, 0), (4, 4, 4))
    assert box_containment([small], [large])[0] == pytest.approx(1.0, abs=1e-7)
    assert box_iou([small], [large])[0] == pytest.approx(small.volume / 64, abs=1e-7)


def test_hand_made_octagon() -> None:
    # Two unit squares turned by 45 degrees against each other share a regular octagon of inradius 1/2.
    flat = axis_box((0, 0, 0), (1, 1, 2))
    turned = OrientedBox(np.zeros(3), pose(turn_deg=(0, 0, 45))[:3, :3], np.array([1.0, 1, 1]))
    assert shared_volumes([flat], [turned])[0] == pytest.approx(2 * (np.sqrt(2) - 1), abs=1e-7)


def test_overlap_is_symmetric_and_survives_a_common_motion() -> None:
    first, second = random_pairs(5, 40)
    world = pose((100, -50, 30), (10, 70, -130))
    expected = box_iou(first, second)
    assert_allclose(box_iou(second, first), expected, atol=1e-7)
    assert_allclose(box_iou([moved(b, world) for b in first], [moved(b, world) for b in second]), expected, atol=1e-7)


def test_a_batch_is_its_singles() -> None:
    first, second = random_pairs(6, 25)
    singles = [box_iou([a], [b])[0] for a, b in zip(first, second, strict=True)]
    assert np.array_equal(box_iou(first, second), singles)
    assert len(box_iou([], [])) == 0


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("extent", [(1, 1, 0), (1, 0, 0), (0, 0, 0)])
def test_flat_boxes_share_nothing_and_give_no_nan(extent: tuple) -> None:
    flat = axis_box((0.1, 0, 0), extent)
    cube = axis_box((0, 0, 0), (1, 1, 1))
    tilted = moved(flat, pose(turn_deg=(20, 30, 40)))
    pairs = ([flat, cube, flat, tilted], [cube, flat, flat, cube])
    for measure in (shared_volumes, box_iou, box_containment):
        assert np.array_equal(measure(*pairs), np.zeros(4))
