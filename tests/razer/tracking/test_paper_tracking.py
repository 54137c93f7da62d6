"""The paper's own tracking: Euclidean S, no gate, banks of raw cosines, moments that add up, tracks at once."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from razer.boxes.oriented_box import OrientedBox, PointMoments
from razer.boxes.rtree_index import BoxIndex
from razer.config import AssociationSettings, BankSettings, MaintenanceSettings, MapperConfig
from razer.tracking.association import assign, find_candidates
from razer.tracking.embedding_bank import EmbeddingBank
from razer.tracking.label_overlap import LabelOverlap
from razer.tracking.track import Track
from razer.tracking.tracker import Tracker
from tests.support.scenes import axis_box, detection, unit

NOTHING = LabelOverlap({}, {}, {}, {})
PAPER_BANK = BankSettings(similarity_scale="cosine", outlier=-1, when_full="drop", merge_hypotheses=False)
CUBE = axis_box((0, 0, 0), (1, 1, 1))


def at_angle(degrees: float) -> np.ndarray:
    return unit(np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0, 0)


def bank_of(settings: BankSettings, *observations: tuple[float, float]) -> EmbeddingBank:
    """A bank of (angle in degrees, confidence)."""
    bank = EmbeddingBank(settings, 4)
    for degrees, confidence in observations:
        bank.add(at_angle(degrees), confidence)
    return bank


def test_the_cost_of_equation_8_by_hand() -> None:
    track = Track(1, detection(CUBE, at_angle(0), quality=0.3), 0, PAPER_BANK)
    track.bank.add(at_angle(30), 0.3)  # e_1 is the mean of both (RAZER eq. 14)
    track.bank.add(at_angle(120), 0.3)
    index = BoxIndex()
    index.put(1, track.box)
    found = detection(axis_box((0.5, 0, 0), (1, 1, 1)), at_angle(60))
    settings = AssociationSettings(geometry_distance="paper", semantic_distance="euclidean", gate=3)
    ((candidate,),) = find_candidates([found], {1: track}, index, NOTHING, settings)
    distance = np.linalg.norm((at_angle(0).astype(float) + at_angle(30)) / 2 - at_angle(60))
    assert candidate.geometry == pytest.approx(1 - 1 / 3)
    assert candidate.semantic == pytest.approx(distance, abs=1e-6)
    assert candidate.cost == pytest.approx(0.6 * 2 / 3 + 0.4 * distance, abs=1e-6)


def test_without_a_gate_the_worst_pair_of_a_candidate_set_is_matched() -> None:
    worst = detection(axis_box((1.04, 0, 0), (1, 1, 1)), -at_angle(0))  # beside the track, and its opposite
    for gate, owner in ((3.0, {0: 1}), (0.5, {})):
        config = AssociationSettings(geometry_distance="paper", semantic_distance="euclidean", gate=gate)
        index = BoxIndex()
        track = Track(1, detection(CUBE, at_angle(0)), 0, PAPER_BANK)
        index.put(1, track.box)
        candidates = find_candidates([worst], {1: track}, index, NOTHING, config)
        assert candidates[0][0].cost == pytest.approx(0.6 + 0.4 * 2)
        assert assign(candidates, gate) == owner


@pytest.mark.parametrize(("join", "outcome"), [(True, "joined"), (False, "born")])
def test_joining_can_be_taken_back(join: bool, outcome: str) -> None:
    config = MapperConfig(association=AssociationSettings(join=join))
    tracker = Tracker(config)
    whole = detection(CUBE, at_angle(0), cells=range(100))
    tracker.update([whole], NOTHING, 0)
    halves = [detection(CUBE, at_angle(0), cells=range(n), mask=mask) for mask, n in enumerate((60, 40))]
    overlap = LabelOverlap({(0, 1): 60, (1, 1): 40}, {0: 60, 1: 40}, {1: 100}, {(0, 1): 60, (1, 1): 40})
    assert [d.outcome for d in tracker.update(halves, overlap, 1)] == ["matched", outcome]


def test_sigma_sim_is_compared_with_the_cosine_to_the_hypothesis() -> None:
    # 40 degrees are a cosine of 0.77; the third is at 62 degrees, 0.47, from the first and at 42, 0.74, from the mean.
    bank = bank_of(PAPER_BANK, (0, 0.5), (40, 0.5), (62, 0.5))
    assert len(bank.embeddings) == 2
    assert_allclose(np.sort(bank.confidences), [1 / 3, 2 / 3])


def test_a_full_bank_drops_what_fits_no_hypothesis() -> None:
    observations = ((0, 0.2), (60, 0.2), (120, 0.2), (180, 0.9))
    assert_allclose(bank_of(PAPER_BANK, *observations).means, [at_angle(a) for a in (0, 60, 120)], atol=1e-6)
    replacing = bank_of(PAPER_BANK.model_copy(update={"when_full": "replace"}), *observations)
    assert_allclose(replacing.embeddings[0], at_angle(180), atol=1e-6)


def test_no_vector_is_refused_at_minus_one() -> None:
    refusing = PAPER_BANK.model_copy(update={"outlier": 0.2})
    assert bank_of(refusing, *[(0, 0.9)] * 3, (180, 0.9)).outliers == 1
    bank = bank_of(PAPER_BANK, *[(0, 0.9)] * 3, (180, 0.9))
    assert (bank.outliers, len(bank.embeddings)) == (0, 2)


def test_hypotheses_stay_apart_where_they_are_not_merged() -> None:
    rng = np.random.default_rng(0)
    noisy = [unit(*(np.eye(64)[0] + 0.15 * rng.normal(size=64))) for _ in range(12)]  # cosines of some 0.4
    apart = PAPER_BANK.model_copy(update={"when_full": "replace"})
    banks = [EmbeddingBank(s, 64) for s in (apart, apart.model_copy(update={"merge_hypotheses": True}))]
    for bank in banks:
        for vector in noisy:
            bank.add(vector, 0.3)
    assert len(banks[0].embeddings) == 3 > len(banks[1].embeddings)
    assert len(banks[0].settled()[0]) == 3
    assert (np.diff(banks[0].confidences) <= 0).all()


def test_confidence_adds_up_to_one_at_most() -> None:
    assert bank_of(PAPER_BANK).peak_confidence == 0
    assert bank_of(PAPER_BANK, (0, 0.3), (0, 0.3), (90, 0.2)).peak_confidence == pytest.approx(0.6)
    assert bank_of(PAPER_BANK, *[(0, 0.3)] * 5).peak_confidence == 1


def test_moments_that_add_up_are_not_taken_from_voxels() -> None:
    settings = MaintenanceSettings(moments="sums")
    boxes = [CUBE, axis_box((2, 0, 0), (1, 0.5, 0.5))]
    track = Track(1, detection(boxes[0]), 0, PAPER_BANK, maintenance=settings)
    track.observe(detection(boxes[1]), 1, 1.0)
    expected = PointMoments.of(np.concatenate([b.corners() for b in boxes]))
    for _ in range(2):
        assert track.moments.count == 16
        assert_allclose(track.moments.scatter, expected.scatter)
        assert_allclose(track.box.center, expected.mean)
        track.refresh(np.random.default_rng(0).normal(size=(50, 3)))
    assert track.n_voxels == 50


def test_the_box_of_moments_is_the_evenly_filled_box() -> None:
    edges = np.array([2.0, 1.0, 0.5])
    steps = (np.arange(40) + 0.5) / 40 - 0.5
    points = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3) * edges + 7
    box = OrientedBox.of_moments(PointMoments.of(points))
    assert_allclose(box.extent, edges, rtol=1e-3)
    assert_allclose(box.center, [7, 7, 7])


def test_a_track_may_be_an_instance_at_once() -> None:
    found = detection(CUBE, cells=range(50))
    tracks = [Track(1, found, 0, PAPER_BANK, maintenance=MaintenanceSettings(tentative=t)) for t in (True, False)]
    for track in tracks:
        for _ in range(50):
            track.count_miss(100, 1.0)
    assert [track.existence.log_odds < 0 for track in tracks] == [True, True]
    assert [track.confirmed for track in tracks] == [False, True]
