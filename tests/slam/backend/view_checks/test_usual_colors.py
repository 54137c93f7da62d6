"""Usual colours, against a law by which made-up pairs differ, among look-alikes."""

from __future__ import annotations

import numpy as np
import pytest

from slam.backend.view_checks.usual_colors import HAND_HELD, LEAST_USUAL, UsualColors


def joined(*pairs):
    """Usual colours of pairs that come as separations and shares."""
    return UsualColors(*(np.concatenate(values).tolist() for values in zip(*pairs, strict=True)))


def share_at(usual, separation):
    return float(usual.at([separation])[0])


@pytest.fixture
def true_pairs(rng):
    """A quarter of the colours differs at a separation of one, and the farther the more, give or take a half."""
    separations = rng.uniform(0.05, 1.0, 200)
    return (separations, 0.25 * separations**2 * rng.uniform(0.5, 1.5, 200))


@pytest.mark.parametrize("apart", [0.3, 0.6, 0.9])
def test_what_is_usual_is_learnt_by_how_far_apart_pictures_are(true_pairs, apart):
    assert share_at(joined(true_pairs), apart) == pytest.approx(0.25 * apart**2, rel=0.25)


def test_each_separation_has_its_own(true_pairs):
    usual = joined(true_pairs)
    assert usual.at([0.3, 0.9]) == pytest.approx([share_at(usual, 0.3), share_at(usual, 0.9)])


@pytest.mark.parametrize("nearest", [0.0, 0.5])
def test_look_alikes_among_them_change_little(true_pairs, rng, nearest):
    """Half as many as there are true ones, seen as if from one place or another, and hardly ever as if from it."""
    false = (rng.uniform(nearest, 1.0, 100), rng.uniform(0.1, 0.4, 100))
    usual, without = joined(true_pairs, false), joined(true_pairs)
    for apart in (0.1, 0.3, 0.6, 0.9):
        assert share_at(usual, apart) < 1.7 * share_at(without, apart) + 0.005


def test_look_alikes_as_if_from_one_place_make_nothing_usual_that_is_not_farther_apart(true_pairs, rng):
    false = (rng.uniform(0.0, 0.2, 200), rng.uniform(0.1, 0.4, 200))
    usual = joined(true_pairs, false)
    assert share_at(usual, 0.1) <= share_at(usual, 0.4) == pytest.approx(0.25 * 0.4**2, rel=0.3)


def test_farther_apart_than_any_it_grows_with_the_square(true_pairs):
    usual = joined(true_pairs)
    assert share_at(usual, 4.0) == pytest.approx(4 * share_at(usual, 2.0))
    assert share_at(usual, 2.0) > share_at(usual, 0.9)


def test_no_share_is_less_than_noise(true_pairs):
    assert share_at(joined(true_pairs), 0.0) == LEAST_USUAL
    assert UsualColors([0.5] * 20, [0.0] * 20).at([0.5, 2.0]) == pytest.approx(LEAST_USUAL)


def test_few_pairs_say_how_much_differs_but_not_how_little():
    """What a hand-held camera does is allowed for until a recording has told what its own does."""
    few, none = UsualColors([0.5] * 3, [0.2] * 3), UsualColors([], [])
    assert share_at(few, 0.5) == pytest.approx(0.2)
    assert share_at(UsualColors([0.5] * 3, [0.0] * 3), 0.4) == share_at(none, 0.4) == pytest.approx(HAND_HELD * 0.4**2)
