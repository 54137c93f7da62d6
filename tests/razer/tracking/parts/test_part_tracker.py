"""Parts of a chair made of cells: found from several views, in any order, and nothing else is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest

from razer.config import MapperConfig
from razer.detection.observed_surface import Cells
from razer.similarity.similarity_scale import SimilarityScale
from razer.tracking.label_overlap import LabelOverlap, nested_masks
from razer.tracking.parts.cell_votes import cell_keys, lattice_keys
from razer.tracking.parts.part_surface import part_surfaces
from razer.tracking.parts.part_tracker import PartFrame, PartTracker
from razer.tracking.step_result import Decision
from tests.support.scenes import axis_box, cells_at, detection

CELL_M = 0.02
WHOLE = 1
Place = tuple[int, int, int]
Shape = frozenset[Place]


def block(*sides: range) -> Shape:
    return frozenset((x, y, z) for x in sides[0] for y in sides[1] for z in sides[2])


SEAT = block(range(20), range(20), range(-1, 1))
BACK = block(range(2), range(20), range(1, 25))
LEGS = block(range(2), range(2), range(-20, -1)) | block(range(18, 20), range(18, 20), range(-20, -1))
CHAIR = SEAT | BACK | LEGS
FLOOR = block(range(-20, 40), range(-20, 40), range(-21, -20))
PARTS = {SEAT, BACK, LEGS}


class View:
    """What a frame shows: some places, masks of them, the tracks that these were given to."""

    def __init__(self, masks: Sequence[Shape], seen: Iterable[Place] = CHAIR | FLOOR, owners: Mapping[Shape, int] = {}):
        self.masks, self.seen, self.owners = masks, frozenset(seen), owners

    def frame(self, index: int, order: Sequence[int] | None = None, novelty: float = 1.0) -> PartFrame:
        places = sorted(self.seen)
        cells = cells_at(places, CELL_M)
        row = {tuple(place): i for i, place in enumerate(cells.coordinates.tolist())}
        shown = [self.masks[i] for i in (order if order is not None else range(len(self.masks)))]
        rows = [sorted(row[place] for place in shape & self.seen) for shape in shown]
        found = [detection(axis_box((0, 0, 0), (1, 1, 1)), cells=r, mask=m, score=0.9) for m, r in enumerate(rows)]
        member = np.concatenate([np.full(len(r), m, np.int32) for m, r in enumerate(rows)])
        nested = nested_masks(member, np.concatenate(rows).astype(np.int32), {})
        decisions = [Decision(m, (), 1.0, "matched", self.owners.get(s, WHOLE)) for m, s in enumerate(shown)]
        return PartFrame(index, cells, found, decisions, LabelOverlap({}, {}, {WHOLE: 99}, {}, nested), novelty)


def tracked(frames: Iterable[PartFrame]) -> PartTracker:
    tracker = PartTracker(MapperConfig(), SimilarityScale())
    for frame in frames:
        tracker.update(frame)
    return tracker


def shapes(tracker: PartTracker, whole: int = WHOLE) -> set[Shape]:
    """The cells of the final parts of a whole that has all cells of the chair."""
    places = np.array(sorted(CHAIR), np.int32)
    vertices = (places * CELL_M).astype(np.float32)
    owners = np.full(len(places), whole, np.int32)
    found = part_surfaces(tracker.parts, vertices, owners, MapperConfig())
    assert {surface.whole for surface in found} <= {whole}
    assert len(np.unique(np.concatenate([np.zeros(0, int), *(s.vertices for s in found)]))) == sum(
        len(s.vertices) for s in found
    )
    return {frozenset(map(tuple, places[surface.vertices].tolist())) for surface in found}


def walk_round() -> list[View]:
    """Six views, of which each misses a side of the chair and a mask or two, as models do."""
    sides = [lambda p: p[0] > 0, lambda p: p[0] < 19, lambda p: p[1] > 0, lambda p: p[1] < 19, lambda p: True]
    pairs = [(CHAIR, SEAT, BACK), (CHAIR, SEAT, LEGS), (CHAIR, BACK, LEGS), (CHAIR, *PARTS)]
    masks = [*pairs, (SEAT, LEGS), (CHAIR, *PARTS)]
    return [View(m, filter(sides[i % 5], CHAIR | FLOOR)) for i, m in enumerate(masks)]


def test_the_parts_of_a_chair_are_found_from_several_views() -> None:
    assert shapes(tracked(view.frame(i) for i, view in enumerate(walk_round()))) == PARTS


@pytest.mark.parametrize("seed", range(4))
def test_parts_are_the_same_in_any_order_of_masks_and_of_frames(seed: int) -> None:
    rng = np.random.default_rng(seed)
    views = walk_round()
    frames = [views[i].frame(i, rng.permutation(len(views[i].masks)).tolist()) for i in rng.permutation(len(views))]
    assert shapes(tracked(frames)) == PARTS


def test_patches_of_texture_that_do_not_come_back_are_no_parts() -> None:
    patches = [block(range(4 * i, 4 * i + 4), range(5, 12), range(-1, 1)) for i in range(5)]
    assert shapes(tracked(View((CHAIR, patch)).frame(i) for i, patch in enumerate(patches))) == set()


def test_a_mask_of_nearly_the_whole_is_no_part() -> None:
    nearly = CHAIR - LEGS
    assert len(nearly) > 0.8 * len(CHAIR)
    assert shapes(tracked(View((CHAIR, nearly)).frame(i) for i in range(4))) == set()


def test_a_union_of_parts_vanishes_where_they_are_known() -> None:
    union = LEGS | BACK
    views = [View((CHAIR, union, *PARTS))] * 3
    assert shapes(tracked(view.frame(i) for i, view in enumerate(views))) == PARTS
    alone = [View((CHAIR, union))] * 3
    assert shapes(tracked(view.frame(i) for i, view in enumerate(alone))) == {union}


def test_a_still_camera_is_no_second_view() -> None:
    """Frames of next to no novelty neither confirm a part nor let it be missed."""
    once = [View((CHAIR, SEAT)).frame(0), *(View((CHAIR,)).frame(i, novelty=1e-6) for i in range(1, 30))]
    (part,) = tracked(once).parts[WHOLE]
    fresh = tracked(once[:1]).parts[WHOLE][0]
    assert part.track.existence.log_odds == pytest.approx(fresh.track.existence.log_odds, abs=1e-3)


def test_what_is_missed_view_after_view_is_forgotten() -> None:
    frames = [View((CHAIR, SEAT)).frame(0), *(View((CHAIR,)).frame(i) for i in range(1, 12))]
    tracker = tracked(frames)
    tracker.prune()
    assert tracker.parts == {}
    beside = tracked([frames[0], *(replace(frame, is_beside=True) for frame in frames[1:])])
    beside.prune()
    assert len(beside.parts[WHOLE]) == 1


def test_fused_wholes_bring_their_parts_together() -> None:
    of_two = dict.fromkeys((CHAIR, *PARTS), 2)
    views = [View((CHAIR, SEAT, BACK)), View((CHAIR, SEAT, LEGS), owners=of_two)] * 3
    tracker = tracked(view.frame(i) for i, view in enumerate(views))
    assert sorted(tracker.parts) == [1, 2]
    tracker.replace(2, WHOLE)
    assert sorted(tracker.parts) == [WHOLE]
    assert shapes(tracker) == PARTS
    tracker.replace(WHOLE, 0)
    assert tracker.parts == {}


def test_a_part_that_is_tracked_as_a_thing_is_its_wholes_once_it_is_fused() -> None:
    tracker = tracked(View((CHAIR, SEAT), owners={SEAT: 7}).frame(i) for i in range(4))
    assert shapes(tracker) == set()
    ((part, whole, log_odds),) = tracker.tracked_parts()
    assert (part, whole) == (7, WHOLE)
    assert log_odds > 4
    tracker.replace(7, WHOLE)
    assert tracker.tracked_parts() == []
    assert shapes(tracker) == {SEAT}


def test_what_lies_beside_its_whole_in_as_many_views_is_no_part_of_it() -> None:
    """A cushion that one mask in two joins with the chair."""
    nested, beside = View((CHAIR, SEAT), owners={SEAT: 7}), View((CHAIR - SEAT, SEAT), owners={SEAT: 7})
    assert tracked(view.frame(i) for i, view in enumerate([nested, beside] * 3)).tracked_parts() == []
    assert tracked(view.frame(i) for i, view in enumerate([nested] * 3)).tracked_parts()


def test_stuff_has_no_parts() -> None:
    frames = [View((CHAIR, SEAT)).frame(i) for i in range(3)]
    stuff = [replace(f, detections=[replace(d, is_stuff=True) for d in f.detections]) for f in frames]
    assert tracked(stuff).parts == {}


def test_keys_of_cells_ascend_as_cells_do_and_tell_them_apart() -> None:
    rng = np.random.default_rng(0)
    cells: Cells = cells_at(rng.integers(-100, 100, (500, 3)), CELL_M)
    keys = cell_keys(cells)
    assert (np.diff(keys) > 0).all()
    np.testing.assert_array_equal(keys, lattice_keys(cells.coordinates))
