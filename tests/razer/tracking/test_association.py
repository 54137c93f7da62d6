"""Association: the assignment against all permutations, the measures and the label overlap on hand-made cases."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from razer.boxes.iou import box_containment, box_iou
from razer.boxes.rtree_index import BoxIndex
from razer.config import AssociationSettings, BankSettings
from razer.detection.lifting import Detection
from razer.similarity.similarity_scale import SimilarityScale
from razer.tracking.association import assign, find_candidates
from razer.tracking.label_overlap import LabelOverlap
from razer.tracking.step_result import Candidate
from razer.tracking.track import Track
from tests.support.scenes import axis_box, detection, moved, pose, random_box, unit

NO_OVERLAP = LabelOverlap({}, {}, {}, {})


def slow_assignment(costs: np.ndarray, gate: float) -> tuple[int, float]:
    """Most pairs within the gate, and the least total cost of that many, over all one-to-one assignments."""
    n, m = costs.shape
    padded = np.full((max(n, m), max(n, m)), np.inf)
    padded[:n, :m] = np.where(costs <= gate, costs, np.inf)
    best = (0, 0.0)
    for order in permutations(range(len(padded))):
        chosen = [c for c in padded[range(len(padded)), order] if np.isfinite(c)]
        best = min(best, (-len(chosen), float(sum(chosen))))
    return -best[0], best[1]


def slow_semantic(cosine: float, unlike: float = 0.0, spread: float = 0.15) -> float:
    """S = 1 - P(same | cosine) of a scale that has seen nothing yet: two normal distributions, each with one in ten
    of the other kind."""

    def density(mean: float) -> float:
        return float(np.exp(-(((np.clip(cosine, unlike, 1) - mean) / spread) ** 2) / 2))

    same, other = 0.9 * density(1) + 0.1 * density(unlike), 0.9 * density(unlike) + 0.1 * density(1)
    return other / (same + other)


def as_candidates(costs: np.ndarray, ids: Sequence[int]) -> list[list[Candidate]]:
    return [[Candidate(t, 0, 0, float(c)) for t, c in zip(ids, row, strict=True) if np.isfinite(c)] for row in costs]


COSTS = st.tuples(st.integers(1, 5), st.integers(1, 5)).flatmap(
    lambda shape: st.lists(
        st.lists(st.sampled_from([*np.linspace(0, 1, 11), np.inf]), min_size=shape[1], max_size=shape[1]),
        min_size=shape[0],
        max_size=shape[0],
    )
)


@given(table=COSTS, gate=st.sampled_from([0.3, 0.45, 0.8]))
@settings(deadline=None, max_examples=120)
def test_assignment_is_the_best_of_all_permutations(table: list[list[float]], gate: float) -> None:
    costs = np.array(table)
    ids = [7, 3, 12, 5, 40][: costs.shape[1]]
    result = assign(as_candidates(costs, ids), gate)
    assert len(set(result.values())) == len(result)
    paid = [costs[i, ids.index(t)] for i, t in result.items()]
    assert all(cost <= gate for cost in paid)
    count, total = slow_assignment(costs, gate)
    assert len(paid) == count
    assert sum(paid) == pytest.approx(total)


def test_no_pair_within_the_gate_assigns_nothing() -> None:
    assert assign([], 0.5) == {}
    assert assign([[], []], 0.5) == {}
    assert assign([[Candidate(1, 1, 1, 0.51)]], 0.5) == {}
    assert assign([[Candidate(1, 1, 1, 0.5)]], 0.5) == {0: 1}


def test_vectors_with_much_in_common_are_told_apart_if_that_is_known() -> None:
    book, table = unit(1, 0.3, 0), unit(1, 0, 0.3)
    found = [detection(axis_box((0.2, 0, 0), (1, 1, 1)), book)]
    settings = AssociationSettings(geometry_distance="paper")

    def cost(unrelated_cosine: float) -> float:
        first = detection(axis_box((0, 0, 0), (1, 1, 1)), table)
        known, index = make_tracks(first, scale=SimilarityScale(unrelated_cosine))
        (row,) = find_candidates(found, known, index, NO_OVERLAP, settings)
        return row[0].cost

    cosine = float(book @ table)
    assert cost(0.0) < settings.gate < cost(cosine)
    expected = 0.4 * (slow_semantic(cosine, unlike=cosine, spread=0.02) - slow_semantic(cosine))
    assert cost(cosine) - cost(0.0) == pytest.approx(expected, abs=1e-6)


def test_the_detection_that_fits_worse_takes_its_second_choice() -> None:
    rows = [[Candidate(1, 0, 0, 0.10), Candidate(2, 0, 0, 0.40)], [Candidate(1, 0, 0, 0.15)]]
    assert assign(rows, 0.45) == {0: 2, 1: 1}


def make_tracks(*found: Detection, scale: SimilarityScale | None = None) -> tuple[dict[int, Track], BoxIndex]:
    tracks = {i: Track(i, d, 0, BankSettings(), scale) for i, d in enumerate(found, start=1)}
    index = BoxIndex()
    for track in tracks.values():
        index.put(track.id, track.box)
    return tracks, index


def candidates_of(
    found: Sequence[Detection], tracks: Sequence[Detection], overlap: LabelOverlap = NO_OVERLAP, **settings: object
) -> list[tuple[Candidate, ...]]:
    known, index = make_tracks(*tracks)
    return find_candidates(found, known, index, overlap, AssociationSettings.model_validate(settings))


UNIT_CUBE = axis_box((0, 0, 0), (1, 1, 1))
HALF_ASIDE = axis_box((0.5, 0, 0), (1, 1, 1))


def test_the_papers_cost_by_hand() -> None:
    ((found,),) = candidates_of(
        [detection(HALF_ASIDE, unit(1, 1))], [detection(UNIT_CUBE, unit(1, 0))], geometry_distance="paper"
    )
    assert found.track_id == 1
    assert found.geometry == pytest.approx(1 - 1 / 3)
    semantic = slow_semantic(np.sqrt(0.5))
    assert found.semantic == pytest.approx(semantic, abs=1e-6)
    assert found.cost == pytest.approx(0.6 * (2 / 3) + 0.4 * semantic, abs=1e-6)


@pytest.mark.parametrize(("cosine", "expected"), [(1.0, 0.1), (0.5, 0.5), (0.0, 0.9), (-1.0, 0.9)])
def test_the_semantic_distance_is_the_probability_of_another_thing(cosine: float, expected: float) -> None:
    """One vector in ten is wrong, so that none is a proof."""
    other = unit(cosine, np.sqrt(1 - cosine**2))
    ((found,),) = candidates_of([detection(HALF_ASIDE, other)], [detection(UNIT_CUBE, unit(1, 0))])
    assert found.semantic == pytest.approx(expected, abs=1e-6)
    assert found.semantic == pytest.approx(slow_semantic(cosine), abs=1e-6)


def test_containment_takes_a_part_for_the_whole() -> None:
    part = [detection(axis_box((0.2, 0.2, 0.2), (0.3, 0.3, 0.3)))]
    whole = [detection(UNIT_CUBE)]
    ((contained,),) = candidates_of(part, whole, geometry_distance="containment")
    assert contained.geometry == pytest.approx(0, abs=1e-6)
    ((by_iou,),) = candidates_of(part, whole, geometry_distance="paper")
    assert by_iou.geometry == pytest.approx(1 - 0.027)


def test_visible_takes_the_better_of_labels_and_boxes() -> None:
    boxes = ([detection(HALF_ASIDE, cells=range(10))], [detection(UNIT_CUBE)])
    grown = 0.55 / (2 * 1.05 - 0.55)  # by 2.5 cm on every side
    ((alone,),) = candidates_of(*boxes)
    assert alone.geometry == pytest.approx(1 - grown)
    by_labels = LabelOverlap({(0, 1): 8}, {0: 9}, {1: 10}, {})
    ((candidate,),) = candidates_of(*boxes, by_labels)
    assert candidate.geometry == pytest.approx(1 - 10 / 19)  # 8 of 11 cells, and 2 of 8 beforehand


def test_leaving_out_hopeless_pairs_changes_nothing_within_the_gate() -> None:
    """The better of visible and box IoU, exact wherever the pair can be matched."""
    rng = np.random.default_rng(0)
    boxes = [random_box(rng) for _ in range(12)]
    found = [detection(b, unit(*rng.uniform(0, 1, 3)), cells=range(10)) for b in boxes]
    tracks = [detection(moved(b, pose(rng.normal(0, 0.05, 3))), unit(*rng.uniform(0, 1, 3))) for b in boxes]
    shared = {(i, t): int(rng.integers(0, 10)) for i in range(12) for t in range(1, 13)}
    overlap = LabelOverlap(shared, dict.fromkeys(range(12), 15), dict.fromkeys(range(1, 13), 12), {})
    within = by_boxes = 0
    rows = candidates_of(found, tracks, overlap, gate=0.45)
    assert sum(map(len, rows)) == 144
    for i, candidate in [(i, c) for i, row in enumerate(rows) for c in row]:
        track = tracks[candidate.track_id - 1]
        of_boxes = box_iou([found[i].box.grown(0.025)], [track.box.grown(0.025)])[0]
        of_voxels = overlap.visible_iou(i, candidate.track_id)
        cost = 0.6 * (1 - max(of_voxels, of_boxes)) + 0.4 * slow_semantic(found[i].embedding @ track.embedding)
        assert (candidate.cost <= 0.45) == (cost <= 0.45)
        if cost <= 0.45:
            assert candidate.cost == pytest.approx(cost, abs=1e-6)
            within, by_boxes = within + 1, by_boxes + (of_boxes > of_voxels)
    assert 0 < by_boxes < within < 144


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("measure", ["visible", "containment", "paper"])
def test_flat_boxes_cost_a_finite_sum(measure: str) -> None:
    wall = [detection(axis_box((0, 0, 2), (2, 2, 0)))]
    ((found,),) = candidates_of(wall, wall, geometry_distance=measure)
    assert np.isfinite(found.cost)
    if measure != "paper":  # a box without volume overlaps nothing in the paper's measure
        assert found.geometry == pytest.approx(0, abs=1e-6)


def test_containment_of_boxes_is_the_measure_used() -> None:
    rng = np.random.default_rng(3)
    found, track = detection(random_box(rng)), detection(random_box(rng))
    ((candidate,),) = candidates_of([found], [track], geometry_distance="containment", box_margin_m=0.05)
    expected = box_containment([found.box.grown(0.05)], [track.box.grown(0.05)])[0]
    assert 1 - candidate.geometry == pytest.approx(expected)


def test_candidates_are_near_or_share_cells_and_come_cheapest_first() -> None:
    near, nearer = axis_box((0.3, 0, 0), (1, 1, 1)), axis_box((0.1, 0, 0), (1, 1, 1))
    far = axis_box((9, 0, 0), (1, 1, 1))
    tracks = [detection(near), detection(far), detection(nearer)]
    found = [detection(UNIT_CUBE, cells=range(4)), detection(axis_box((-9, 0, 0), (1, 1, 1)))]
    first, second = candidates_of(found, tracks)
    assert [c.track_id for c in first] == [3, 1]
    assert second == ()
    # A track whose box went stale is found by the labels under the detection; 99 is no track any more.
    overlap = LabelOverlap({(0, 2): 40, (0, 99): 1}, {0: 40}, {2: 40, 99: 1}, {})
    assert [c.track_id for c in candidates_of(found, tracks, overlap)[0]] == [2, 3, 1]
    assert [c.track_id for c in candidates_of(found, tracks, overlap, geometry_distance="paper")[0]] == [3, 1]


def test_a_gap_within_the_search_margin_still_makes_a_candidate() -> None:
    beside = axis_box((1.08, 0, 0), (1, 1, 1))
    assert len(candidates_of([detection(UNIT_CUBE)], [detection(beside)], geometry_distance="paper")[0]) == 1
    beyond = axis_box((1.3, 0, 0), (1, 1, 1))
    assert candidates_of([detection(UNIT_CUBE)], [detection(beyond)], geometry_distance="paper") == [()]


def test_where_labels_decide_a_neighbour_that_shares_nothing_is_no_candidate() -> None:
    beside = axis_box((1.08, 0, 0), (1, 1, 1))
    assert candidates_of([detection(UNIT_CUBE)], [detection(beside)]) == [()]


def test_each_detection_is_compared_by_its_own_vector() -> None:
    vectors = [unit(1, 0, 0), unit(0, 1, 0), unit(0, 0, 1)]
    tracks = [detection(UNIT_CUBE, v) for v in reversed(vectors)]
    for i, row in enumerate(candidates_of([detection(UNIT_CUBE, v) for v in vectors], tracks)):
        semantic = {c.track_id: c.semantic for c in row}
        assert semantic == pytest.approx({t: 0.1 if t == 3 - i else 0.9 for t in (1, 2, 3)}, abs=1e-6)


def fully_covered(cells: int) -> LabelOverlap:
    """Of track 1 so many cells are in view, all of them under the one detection, which covers nothing else."""
    return LabelOverlap({(0, 1): cells}, {0: cells}, {1: cells}, {})


FAR_BOX = axis_box((0.9, 0, 0), (1, 1, 1))  # boxes that say nothing: the labels decide


@pytest.mark.parametrize(
    ("cells", "cosine", "matched"),
    [
        (1, 1.0, True),  # little is in view, and it looks the same
        (1, 0.0, False),  # one cell in view is no IoU of 1
        (12, 0.0, False),  # 14 of 20: V = 0.3, and S = 0.9
        (12, 0.5, True),  # it looks like either
        (40, 0.0, True),  # 42 of 48: one vector in ten is wrong, and the place is right
        (400, -1.0, True),
    ],
)
def test_an_unlike_vector_forbids_what_few_cells_suggest(cells: int, cosine: float, matched: bool) -> None:
    found = [detection(FAR_BOX, unit(cosine, np.sqrt(1 - cosine**2)))]
    rows = candidates_of(found, [detection(UNIT_CUBE, unit(1, 0))], fully_covered(cells))
    expected = 0.6 * (1 - (cells + 2) / (cells + 8)) + 0.4 * slow_semantic(cosine)
    assert rows[0][0].cost == pytest.approx(expected, abs=1e-6)
    assert assign(rows, AssociationSettings().gate) == ({0: 1} if matched else {})


def test_of_two_fitting_tracks_the_like_one_is_taken() -> None:
    """Where the place is the same, the vector decides: a cup in front of the place of another thing."""
    found = [detection(UNIT_CUBE, unit(0, 1))]
    tracks = [detection(UNIT_CUBE, unit(1, 0)), detection(UNIT_CUBE, unit(0, 1))]
    overlap = LabelOverlap({(0, 1): 40, (0, 2): 30}, {0: 70}, {1: 40, 2: 30}, {})
    assert assign(candidates_of(found, tracks, overlap), AssociationSettings().gate) == {0: 2}


@pytest.mark.parametrize("measure", ["visible", "containment", "paper"])
def test_a_frame_without_any_near_box_keeps_what_its_labels_say(measure: str) -> None:
    """The R-tree finds nothing in the whole frame: the labels under the detections still name their tracks."""
    away = axis_box((30, 0, 0), (1, 1, 1))
    found = [detection(away), detection(away)]
    overlap = LabelOverlap({(0, 1): 90, (1, 2): 30, (1, 99): 8}, {0: 95, 1: 38}, {1: 90, 2: 50, 99: 8}, {})
    rows = candidates_of(found, [detection(UNIT_CUBE), detection(UNIT_CUBE)], overlap, geometry_distance=measure)
    if measure != "visible":
        assert rows == [(), ()]
        return
    assert [[c.track_id for c in row] for row in rows] == [[1], [2]]
    assert [row[0].geometry for row in rows] == pytest.approx([1 - 92 / 103, 1 - 32 / 66])
    assert assign(rows, AssociationSettings().gate) == {0: 1, 1: 2}
