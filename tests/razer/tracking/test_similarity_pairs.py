"""Which pairs the similarity scale learns from, and that the tracker shows it those."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from razer.config import BankSettings, MapperConfig
from razer.detection.lifting import Detection
from razer.similarity.similarity_scale import SimilarityScale
from razer.tracking.embedding_bank import EmbeddingBank
from razer.tracking.label_overlap import LabelOverlap
from razer.tracking.similarity_pairs import same_cosines, unlike_cosines
from razer.tracking.step_result import Candidate
from razer.tracking.tracker import Tracker
from tests.support.scenes import axis_box, detection, unit

BOX = axis_box((0, 0, 0), (1, 1, 1))


def of(embedding: np.ndarray, mask: int = 0) -> Detection:
    return detection(BOX, embedding, mask=mask)


def bank(*observations: np.ndarray) -> EmbeddingBank:
    result = EmbeddingBank(BankSettings(), 4)
    for each in observations:
        result.add(each, 0.5)
    return result


X, Y, XY = unit(1, 0, 0, 0), unit(0, 1, 0, 0), unit(1, 1, 0, 0)


def test_pairs_of_unlike_things_are_of_different_masks() -> None:
    found = [of(X, 0), of(XY, 0), of(Y, 1), of(XY, 2)]
    diagonal = np.sqrt(0.5)
    expected = [0, diagonal, diagonal, 1, diagonal]  # 0-2, 0-3, 1-2, 1-3, 2-3
    np.testing.assert_allclose(np.sort(unlike_cosines(found)), np.sort(expected), atol=1e-6)
    assert len(unlike_cosines(found[:1])) == len(unlike_cosines([])) == 0
    assert len(unlike_cosines(found[:2])) == 0


def test_stuff_is_no_unlike_thing() -> None:
    """A frame shows one floor in several pieces."""
    pieces = [replace(of(X, mask), is_stuff=True) for mask in (2, 3)]
    np.testing.assert_allclose(unlike_cosines([of(X, 0), of(Y, 1), *pieces]), [0], atol=1e-6)
    assert len(unlike_cosines(pieces)) == 0


def near(*ids: int, far: tuple[int, ...] = ()) -> tuple[Candidate, ...]:
    return tuple([Candidate(i, 0.4, 0, 0) for i in ids] + [Candidate(i, 0.6, 0, 0) for i in far])


def test_views_of_one_thing_lie_on_one_track_that_nothing_else_lies_on() -> None:
    banks = {1: bank(X), 2: bank(XY, XY, Y), 3: bank(Y)}
    found = [of(X, 0), of(X, 1)]
    cases = {
        (near(1), near(2)): [1.0, np.sqrt(0.5)],  # the second's strongest hypothesis is XY
        (near(1, far=(3,)), near(far=(1, 2))): [1.0],
        (near(1, 2), ()): [],  # two tracks fit
        (near(1), near(1)): [],  # two detections claim one
        (near(7), ()): [],  # gone
    }
    for candidates, expected in cases.items():
        np.testing.assert_allclose(same_cosines(found, candidates, banks), expected, atol=1e-6)


def test_the_order_of_detections_changes_nothing() -> None:
    rng = np.random.default_rng(0)
    found = [of(unit(*row), mask) for mask, row in enumerate(rng.normal(size=(6, 4)))]
    banks = {i: bank(unit(*row)) for i, row in enumerate(rng.normal(size=(6, 4)))}
    candidates = [near(i) for i in (3, 1, 1, 5, 0, 2)]
    scales = []
    for order in (range(6), rng.permutation(6)):
        scale = SimilarityScale()
        chosen = [found[i] for i in order]
        scale.observe(unlike_cosines(chosen), same_cosines(chosen, [candidates[i] for i in order], banks))
        scales.append(scale.calibrated)
    assert scales[0] == scales[1]


def test_a_tracker_learns_what_its_embedder_means() -> None:
    """Two things side by side, frame after frame, at a cosine of 0.88 to each other and of 0.98 to themselves."""
    rng = np.random.default_rng(1)
    boxes = [axis_box((0, 0, 0), (1, 1, 1)), axis_box((5, 0, 0), (1, 1, 1))]

    def seen(thing: int) -> np.ndarray:
        common = [3.0, 0.0, 0.0] if thing else [3.0, 1.5, 0.0]
        return unit(*common, *rng.normal(0, 0.1, 20)).astype(np.float32)

    tracker = Tracker(MapperConfig(), scale=SimilarityScale())
    nothing = LabelOverlap({}, {}, {}, {})
    for index in range(60):
        found = [detection(boxes[thing], seen(thing), mask=thing) for thing in (0, 1)]
        tracker.update(found, nothing, index)
    one, other = tracker.tracks.values()
    cosine = seen(0) @ seen(1)
    assert cosine > 0.8
    assert tracker.scale.units(float(np.mean([seen(0) @ seen(1) for _ in range(99)]))) == pytest.approx(0, abs=0.35)
    assert tracker.scale.units(float(np.mean([seen(0) @ seen(0) for _ in range(99)]))) == pytest.approx(1, abs=0.35)
    assert one.bank.log_odds_same(other.bank) < 0
    assert tracker.scale.log_odds(one.bank.similarity(seen(1))) < 0
