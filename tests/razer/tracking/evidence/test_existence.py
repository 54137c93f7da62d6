"""Existence: against literal products of probabilities, and the cases that counting frames got wrong."""

from __future__ import annotations

from collections.abc import Sequence
from math import log, prod

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from razer.tracking.evidence.existence import DETECTION_RATES, HALF_LIFE_VIEWS, PHANTOM_RATE, Existence
from razer.tracking.evidence.view_novelty import ViewNovelty
from tests.support.scenes import pose

PRUNED = -2.0  # as the tracker has it


def after(score: float, views: Sequence[bool], share: float = 1.0) -> Existence:
    """First detected with a score, and then in view so many times: detected (True) or not, each a share of a view."""
    existence = Existence(score)
    for detected in views:
        existence.count(share * detected, share * (not detected))
    return existence


def slow_log_odds(score: float, views: Sequence[bool]) -> float:
    """The two probabilities of all that was observed, multiplied view by view; older views count less."""
    age = range(len(views) - 1, -1, -1)
    weights = [0.5 ** (a / HALF_LIFE_VIEWS) for a in age]

    def of(rate: float) -> float:
        return prod((rate if hit else 1 - rate) ** w for hit, w in zip(views, weights, strict=True))

    thing = score * sum(map(of, DETECTION_RATES)) / len(DETECTION_RATES)
    return log(thing) - log((1 - score) * of(PHANTOM_RATE))


@given(score=st.floats(0.2, 0.8), views=st.lists(st.booleans(), max_size=30))
@settings(deadline=None, max_examples=60)
def test_log_odds_are_the_ratio_of_two_products(score: float, views: list[bool]) -> None:
    assert after(score, views).log_odds == pytest.approx(slow_log_odds(score, views), abs=1e-6)


def test_one_detection_by_hand() -> None:
    assert Existence(0.5).log_odds == pytest.approx(0)
    assert Existence(0.8).log_odds == pytest.approx(log(4))
    assert Existence(0.8).probability == pytest.approx(0.8)
    # One hit: the mean of 0.2, 0.4, 0.6 and 0.9 against 0.03; one miss: the mean of the rest against 0.97.
    assert after(0.5, [True]).log_odds == pytest.approx(log(0.525 / 0.03))
    assert after(0.5, [False]).log_odds == pytest.approx(log(0.475 / 0.97))


def test_no_score_is_beyond_doubt() -> None:
    assert Existence(1.0).log_odds == Existence(0.8).log_odds == pytest.approx(log(4))
    assert Existence(0.0).log_odds == pytest.approx(-log(4))


@given(views=st.lists(st.booleans(), max_size=20))
@settings(deadline=None, max_examples=40)
def test_a_detection_speaks_for_it_and_a_miss_against(views: list[bool]) -> None:
    now = after(0.6, views).log_odds
    assert after(0.6, [*views, True]).log_odds > now > after(0.6, [*views, False]).log_odds


@pytest.mark.parametrize("n_views", [10, 50, 500])
def test_what_a_detector_finds_in_a_fifth_of_the_views_is_there(n_views: int) -> None:
    """A refrigerator: found first with 0.6, and then after four misses again, over and over."""
    existence = Existence(0.6)
    for view in range(1, n_views + 1):
        detected = view % 5 == 0
        existence.count(detected, not detected)
        assert existence.log_odds > PRUNED
    assert existence.log_odds > 0


@pytest.mark.parametrize(("score", "no_instance", "pruned"), [(0.3, 0, 2), (0.5, 1, 5), (0.8, 3, 11)])
def test_a_phantom_of_one_view_is_refuted_by_the_views_that_do_not_show_it(
    score: float, no_instance: int, pruned: int
) -> None:
    """The surer its one mask was, the longer it takes; the numbers follow from the literal products."""
    odds = [slow_log_odds(score, [False] * n) for n in range(60)]
    assert [next(n for n, o in enumerate(odds) if o < bound) for bound in (0, PRUNED)] == [no_instance, pruned]
    for n, bound in ((no_instance, 0), (pruned, PRUNED)):
        assert after(score, [False] * n).log_odds < bound
        assert n == 0 or after(score, [False] * (n - 1)).log_odds >= bound


@pytest.mark.parametrize("hits", [3, 30, 3000])
def test_what_was_carried_away_is_gone_however_often_it_was_seen(hits: int) -> None:
    existence = after(0.9, [True] * hits)
    assert existence.probability > 0.99
    assert after(0.9, [True] * hits + [False]).log_odds > 0  # one miss does nothing
    for _ in range(999):
        existence.count(0.0, 1.0)
    assert existence.log_odds < PRUNED


def test_a_frame_counts_as_the_share_of_a_view_that_it_is() -> None:
    whole, parts = after(0.7, [True, False, False]), after(0.7, [True] * 10 + [False] * 20, share=0.1)
    assert parts.log_odds == pytest.approx(whole.log_odds, abs=0.02)


def walk(n_frames: int, length_m: float = 10.0) -> list[np.ndarray]:
    """Poses along a straight line, a tremble of the hand on each (2 mm, 0.2 degrees)."""
    rng = np.random.default_rng(n_frames)
    steps = zip(np.linspace(0, length_m, n_frames), rng.normal(0, 0.002, n_frames), strict=True)
    return [pose((x, tremble, 0), (0, 100 * tremble, 0)) for x, tremble in steps]


@pytest.mark.parametrize("rate", [0.2, 0.6])
def test_many_frames_of_a_walk_say_what_few_do(rate: float) -> None:
    """Detected along the same stretches of a walk, frame by frame: 5,000 frames, 500 and 50."""
    log_odds = []
    for n_frames in (5000, 500, 50):
        novelty, existence = ViewNovelty(), Existence(0.6)
        for world_from_camera in walk(n_frames):
            detected = world_from_camera[0, 3] % 1.0 < rate
            share = novelty.of(world_from_camera)
            existence.count(share * detected, share * (not detected))
        log_odds.append(existence.log_odds)
    assert log_odds[2] > 5
    assert log_odds[:2] == pytest.approx([log_odds[2]] * 2, rel=0.4)  # 67 views of 15 cm, against 50 of 20 cm


def test_a_tripod_makes_no_certainty() -> None:
    """The same mistake, 5,000 times from one place; and a thing that one place never shows well."""
    novelty, phantom, missed = ViewNovelty(), Existence(0.6), Existence(0.6)
    for world_from_camera in walk(5000, length_m=0.0):
        share = novelty.of(world_from_camera)
        phantom.count(share, 0.0)
        missed.count(0.0, share)
    assert 0.6 < phantom.probability < 0.9995
    assert missed.log_odds > PRUNED


def test_a_duplicate_adds_what_it_was_seen_of() -> None:
    """While one of both was matched, the other was not missed."""
    one, other = Existence(0.4, hits=5, misses=7), Existence(0.8, hits=3, misses=2)
    one.absorb(other)
    assert (one.first_score, one.hits, one.misses) == (0.8, 5, 2)


def test_probability_is_that_of_the_log_odds_at_any_size() -> None:
    for existence in (after(0.6, [True]), after(0.6, [False] * 9)):
        assert log(existence.probability / (1 - existence.probability)) == pytest.approx(existence.log_odds)
    assert after(0.9, [True] * 5000).probability == pytest.approx(1)
    assert 0 <= after(0.1, [False] * 5000).probability < 1e-4
