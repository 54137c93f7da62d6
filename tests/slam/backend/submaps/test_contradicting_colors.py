"""Whether views, placed to each other, contradict each other by their colours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from slam.backend.submaps.placement_check import PLACED, SAME_HUES, PlacedPair, Scrutiny, UsualDifferences, contradict
from slam.backend.view_checks.color_check import color_difference
from tests.support.painted_walls import CONFIG, HERE, lit_otherwise, painted, plaster, view, wall, with_board


def all_usually(share):
    """What is usual of pairs, however far apart."""
    return lambda pairs: UsualDifferences(np.full(len(pairs), share))


def test_views_that_share_nothing_thin_out_no_contradiction():
    """A board that hangs elsewhere in one pair of views, beside pairs that say nothing."""
    rgb, depth = wall()
    board = rgb.copy()
    board[60:120, 80:200] = (10, 40, 30)
    pair = PlacedPair(view(rgb, depth), view(board, depth), HERE)
    apart = PlacedPair(view(rgb, depth), view(rgb, depth), np.diag([-1.0, 1, -1, 1]))  # back to back
    assert contradict([pair, *[apart] * 20], all_usually(0.02), CONFIG)
    assert not contradict([pair, *[apart] * 20], all_usually(0.05), CONFIG)
    assert not contradict([apart], all_usually(0.0), CONFIG)


@pytest.fixture(scope="module")
def rim():
    """Views two metres aside of each other, which share the rim of a wall that has other colours there."""
    rgb, depth = wall()
    other = rgb.copy()
    other[80:160] = (10, 40, 30)
    aside = np.eye(4)
    aside[0, 3] = 2.2
    return PlacedPair(view(rgb, depth), view(other, depth), aside)


def test_few_readings_say_nothing_where_more_are_asked_for(rim):
    """Of 4,800 that each view has the two share 480."""
    assert contradict([rim] * 2, all_usually(0.0), CONFIG)
    assert not contradict([rim] * 2, all_usually(0.0), CONFIG, Scrutiny(fewest_told=1500))
    assert contradict([rim] * 4, all_usually(0.0), CONFIG, Scrutiny(fewest_told=1500))


def test_pairs_count_by_what_they_share(rim):
    """Of the rim a third has other colours, of all readings 2 %; a third of the pairs are such."""
    rgb, depth = wall()
    whole = PlacedPair(view(rgb, depth), view(rgb, depth), HERE)
    assert not contradict([rim, whole, whole], all_usually(0.01), CONFIG, Scrutiny(many_told=3))
    assert contradict([rim] * 5, all_usually(0.01), CONFIG)


def test_where_a_pair_may_have_drifted_its_colours_say_nothing():
    """They are those of the stripe beside; what stands where the other looked through would still contradict."""
    rgb, depth = wall()
    pair = PlacedPair(view(rgb, depth), view(rgb[..., [2, 0, 1]], depth), HERE)
    drifted = replace(pair, drift_m=CONFIG.loop_closure.drift_m + 0.01)
    assert not contradict([drifted] * 20, all_usually(0.0), CONFIG)
    assert contradict([drifted] * 20 + [pair], all_usually(0.0), CONFIG)
    through = PlacedPair(view(rgb, depth), view(rgb, depth * 0.5), HERE, drifted.drift_m)
    assert contradict([through], all_usually(0.0), CONFIG)


@pytest.fixture(scope="module")
def true_and_false():
    """A pair of views of one wall, and one in which a hundredth of it has another colour."""
    rgb, depth = wall()
    spot = rgb.copy()
    spot[100:124, 100:132] = (10, 40, 30)
    return tuple(PlacedPair(view(rgb, depth), view(other, depth), HERE) for other in (rgb, spot))


def dimmed(of):
    """The view in a light that turns from one side to the other by a hundredth."""
    across = np.linspace(0.98, 1.0, of.sparse.rgb.shape[1])[:, None]
    return replace(of, sparse=replace(of.sparse, rgb=np.rint(of.sparse.rgb * across).astype(np.uint8)))


@pytest.mark.parametrize(
    ("n_true", "n_false", "usual", "is_contradiction"),
    [
        (6, 4, 0.002, True),
        (7, 3, 0.002, False),  # a true place has as many
        (6, 4, 0.005, False),  # nor is that unusual here
        (5, 4, 0.002, False),  # these are too few
    ],
)
def test_a_little_counts_where_it_is_of_many_pairs(true_and_false, n_true, n_false, usual, is_contradiction):
    """Of things that are alike but for their seats."""
    pairs = [pair for pair, n in zip(true_and_false, (n_true, n_false), strict=True) for _ in range(n)]
    assert contradict(pairs, all_usually(usual), CONFIG, Scrutiny(many_told=10)) is is_contradiction
    assert not contradict(pairs, all_usually(usual), CONFIG)


@pytest.mark.parametrize(
    ("n_true", "n_false", "bare_share", "usual_light", "is_contradiction"),
    [
        (0, 15, 0.001, 1.0, True),
        (11, 4, 0.001, 1.0, True),
        (14, 1, 0.001, 1.0, False),  # one is chance
        (0, 14, 0.001, 1.0, False),  # these are too few
        (0, 15, 0.003, 1.0, False),  # here colours are not so clean that other rules overlook as much
        (0, 15, 0.001, 0.0, False),  # light is another
    ],
)
def test_a_little_counts_again_and_again_where_colours_are_clean(
    true_and_false, n_true, n_false, bare_share, usual_light, is_contradiction
):
    """All of both views differs by less than a hundredth; a hundredth of some pairs is of another colour."""
    true, false = (replace(pair, second=dimmed(pair.second)) for pair in true_and_false)
    pairs = [true] * n_true + [false] * n_false
    usual = UsualDifferences(np.full(len(pairs), 0.01), usual_light, 1.0, np.full(len(pairs), bare_share))
    assert contradict(pairs, lambda _: usual, CONFIG) is is_contradiction
    assert not contradict(pairs, lambda _: usual, CONFIG, PLACED)  # more is seen of it with each frame


def test_half_as_many_are_too_many_where_pairs_are_looked_at_strictly(true_and_false):
    true, false = true_and_false
    strictly = Scrutiny(many_told=10, many=1 / 2)
    assert contradict([true] * 8 + [false] * 2, all_usually(0.002), CONFIG, strictly)
    assert not contradict([true] * 9 + [false] * 1, all_usually(0.002), CONFIG, strictly)


def test_less_is_too_much_on_the_whole_where_pairs_are_looked_at_strictly():
    """A board of an eighth of the wall, where three times as many as 5 % may differ, or twice as many."""
    rgb, depth = wall()
    board = rgb.copy()
    board[60:120, 80:240] = (10, 40, 30)
    pair = PlacedPair(view(rgb, depth), view(board, depth), HERE)
    assert not contradict([pair], all_usually(0.05), CONFIG)
    assert contradict([pair], all_usually(0.05), CONFIG, Scrutiny(share=2 / 3))


def test_much_that_differs_in_one_pair_of_few_counts(true_and_false):
    rgb, depth = wall()
    other = PlacedPair(view(rgb, depth), view(rgb[..., [2, 0, 1]], depth), HERE)
    assert contradict([other, true_and_false[0], true_and_false[0]], all_usually(0.01), CONFIG, Scrutiny(many_told=10))


IN_ONE_LIGHT = UsualDifferences(np.array([0.01]), 0.01, 0.02)


def usually(pairs):
    """What is usual of a recording in one light."""
    return IN_ONE_LIGHT._replace(shares=np.full(len(pairs), IN_ONE_LIGHT.shares[0]))


def test_a_place_that_is_lit_otherwise_is_no_other_place():
    """Unless nobody knows what is usual, or hues change, too, or what differs is no light."""
    rgb, depth = plaster()
    here, lit = view(rgb, depth), lit_otherwise(rgb)
    relit = PlacedPair(here, view(lit, depth), HERE)
    assert not contradict([relit], usually, CONFIG)
    assert contradict([relit], all_usually(0.01), CONFIG)
    for other in (painted(lit, 160), with_board(rgb)):
        assert contradict([PlacedPair(here, view(other, depth), HERE)], usually, CONFIG)


def test_more_than_light_changes_is_another_place_in_any_light():
    """Boards on a third of a wall whose light differs by little."""
    rgb, depth = plaster()
    lit = rgb * np.linspace(0.8, 1.0, 320)[:, None]
    lit[40:200, 60:220] *= 0.4
    pair = PlacedPair(view(rgb, depth), view(lit, depth), HERE)
    assert contradict([pair], usually, CONFIG)


def test_hues_that_keep_a_place_from_being_believed_do_not_part_it_again():
    """By a tenth more than light may change, and not by a third."""
    rgb, depth = plaster()
    here, there = view(rgb, depth), view(lit_otherwise(rgb), depth)
    measured = color_difference(here, there, HERE, CONFIG.free_space)
    usual = UsualDifferences(np.array([0.01]), 0.01, measured.hue_change / SAME_HUES / 1.1)
    pair = PlacedPair(here, there, HERE)
    assert contradict([pair], lambda _: usual, CONFIG)
    assert not contradict([pair], lambda _: usual, CONFIG, PLACED)
    more = usual._replace(hue_change=measured.hue_change / SAME_HUES / 1.3)
    assert contradict([pair], lambda _: more, CONFIG, PLACED)
