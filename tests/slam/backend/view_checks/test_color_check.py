"""Whether the colours of two views go together."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from razer.frame import Frame, Intrinsics
from slam.backend.submaps.placement_check import PLACED, SAME_HUES, PlacedPair, Scrutiny, UsualDifferences, contradict
from slam.backend.view_checks.color_check import color_correlation, color_difference, other_colors
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import FeatureExtractor
from slam.frontend.keyframes import STILL, View

CAMERA = Intrinsics(320, 240, 260.0, 260.0, 159.5, 119.5)
CONFIG = SlamConfig()
HERE = np.eye(4)


def wall(shift=0):
    """Depth and colours of a wall two metres away, with broad stripes of three colours, some pixels aside."""
    stripe = ((np.arange(320) + shift) // 40) % 3
    colors = np.array([(200, 60, 50), (60, 160, 70), (50, 70, 190)], np.uint8)
    return np.broadcast_to(colors[stripe], (240, 320, 3)), np.full((240, 320), 2.0, np.float32)


def view(rgb, depth):
    frame = Frame(0, 0.0, np.ascontiguousarray(rgb, np.uint8), depth, CAMERA)
    return View.of(frame, FeatureExtractor(CONFIG).extract(frame, ColorCalibration.nominal()), STILL, CONFIG)


def correlation(a, b, motion=HERE):
    return color_correlation(a, b, motion, CONFIG.free_space)


def test_one_wall_under_another_exposure_and_white_balance_is_one_wall():
    rgb, depth = wall()
    assert correlation(view(rgb, depth), view(rgb * (0.5, 0.6, 0.8), depth)) > 0.97


def test_a_wall_of_other_colours_is_another():
    rgb, depth = wall()
    assert correlation(view(rgb, depth), view(rgb[..., [2, 0, 1]], depth)) < 0.0


def test_a_wall_moved_by_a_stripe_goes_together_at_that_motion_alone():
    rgb, depth = wall()
    stripe_m = 40 * 2.0 / 260.0
    moved = view(np.roll(rgb, 40, axis=1), depth)
    at = np.eye(4)
    at[0, 3] = -stripe_m
    assert correlation(view(rgb, depth), moved, at) > 0.95
    assert correlation(view(rgb, depth), moved) < 0.3


@pytest.mark.parametrize("other_m", [2.0, 3.0])
def test_what_says_nothing_speaks_against_nothing(other_m):
    """Plain walls, and surfaces that are not the same."""
    plain = np.full((240, 320, 3), 120, np.uint8)
    rgb, depth = wall() if other_m == 3.0 else (plain, wall()[1])
    assert correlation(view(plain, wall()[1]), view(rgb, depth * other_m / 2)) == 1.0


def other(a, b, motion=HERE):
    return other_colors(a, b, motion, CONFIG.free_space)


def test_no_colour_is_another_under_another_exposure_or_a_pixel_off():
    rgb, depth = wall()
    assert other(view(rgb, depth), view(rgb * (0.5, 0.6, 0.8), depth)) == 0.0
    shifted = np.pad(rgb, ((0, 0), (3, 0), (0, 0)), mode="edge")[:, :320]
    assert other(view(rgb, depth), view(shifted, depth)) < 0.01


@pytest.mark.parametrize("exposure", [0.6, 1.0, 1.5, 2.0])
def test_what_is_overexposed_may_be_any_brighter(exposure):
    """A window in a wall that has the colours of a wall in one view, and is white in the other."""
    depth = wall()[1]
    rgb = np.full((240, 320, 3), 110, np.uint8)
    rgb[60:140, 80:200] = (210, 220, 230)
    exposed = np.minimum(rgb * exposure, 255)
    views = view(rgb, depth), view(exposed, depth)
    assert other(*views) == other(*reversed(views)) == 0.0


def test_a_seat_that_is_a_seventh_darker_has_another_colour_and_lines_have_none():
    rgb, depth = wall()
    seat, lines = rgb.copy(), rgb.copy()
    seat[60:120, 80:200] = rgb[60:120, 80:200] * 0.85
    assert other(view(rgb, depth), view(seat, depth)) == pytest.approx(60 * 120 / (240 * 320), rel=0.1)
    lines[10::24] = lines[11::24] = (10, 40, 30)  # half a pixel of what is compared
    assert other(view(rgb, depth), view(lines, depth)) == 0.0


def test_what_differs_by_no_more_than_most_of_a_view_does_is_no_other_colour():
    """Light that changed from left to right, by up to a fifth, as that of another time of the day; not a dark board."""
    rgb, depth = wall()
    light = np.linspace(0.8, 1.2, 320)[None, :, None]
    lit, board = rgb * light, rgb * light
    board[60:120, 80:200] = (10, 40, 30)
    assert other(view(rgb, depth), view(lit, depth)) < 0.01
    assert other(view(rgb, depth), view(board, depth)) == pytest.approx(60 * 120 / (240 * 320), rel=0.1)


@pytest.mark.parametrize("is_swapped", [False, True])
def test_a_board_on_the_wall_is_told_by_its_share_of_the_view(is_swapped):
    """Most of both views goes together: their correlation is high."""
    rgb, depth = wall()
    board = rgb.copy()
    board[60:120, 80:200] = (10, 40, 30)
    views = view(rgb, depth), view(board, depth)
    assert other(*(reversed(views) if is_swapped else views)) == pytest.approx(60 * 120 / (240 * 320), rel=0.1)
    assert correlation(*views) > 0.5


def test_surfaces_that_are_not_the_same_say_nothing_of_colours():
    rgb, depth = wall()
    assert other(view(rgb, depth), view(rgb[..., [2, 0, 1]], 1.5 * depth)) is None


def framed(away_m, width_m):
    """A white wall with a black frame of some width, a metre across, seen from so far away."""
    across = np.linspace(-1, 1, 4 * 320)[None, :] * 160 / 260 * away_m
    up = np.linspace(-1, 1, 4 * 240)[:, None] * 120 / 260 * away_m
    aside = np.maximum(np.abs(across - 0.3), np.abs(up))
    is_black = (aside < 0.5) & (aside > 0.5 - width_m)
    fine = np.where(is_black, 30, 230).astype(np.uint8)
    rgb = np.repeat(cv2.resize(fine, (320, 240), interpolation=cv2.INTER_AREA)[..., None], 3, axis=2)
    return view(rgb, np.full((240, 320), away_m, np.float32))


@pytest.mark.parametrize("far_m", [1.5, 2.0, 3.0, 4.0])
def test_what_a_view_from_afar_blurs_has_no_other_colours(far_m):
    near, nearer = np.eye(4), np.eye(4)
    near[2, 3], nearer[2, 3] = 1.0 - far_m, far_m - 1.0
    assert other(framed(1.0, 0.05), framed(far_m, 0.05), near) < 0.002
    assert other(framed(far_m, 0.05), framed(1.0, 0.05), nearer) < 0.002


def test_what_is_wide_enough_for_both_is_told_from_afar_as_well():
    """Two fifths of what both views show are black in one alone."""
    nearer = np.eye(4)
    nearer[2, 3] = 2.0
    assert other(framed(3.0, 0.0), framed(1.0, 0.3), nearer) > 0.35


def darkened(rgb, power):
    """Under less light, by a camera whose tone curve makes dark colours darker still."""
    return 255 * (rgb / 255.0) ** power


@pytest.mark.parametrize("power", [1.0, 1.5, 0.7])
def test_a_tone_curve_is_no_other_colour_and_hides_none(power):
    """A wall of light and dark stripes, of which a board covers an eighth."""
    rgb, depth = wall()
    board = rgb.copy()
    board[60:120, 80:240] = (10, 140, 30)
    here, there = view(rgb, depth), view(darkened(rgb, power), depth)
    assert other_colors(here, there, HERE, CONFIG.free_space) < 0.005
    other = other_colors(here, view(darkened(board, power), depth), HERE, CONFIG.free_space)
    assert other == pytest.approx(0.125, abs=0.03)


@pytest.mark.parametrize("power", [1.3, 0.8])
def test_a_tone_curve_hides_no_faint_colour(power):
    """A seat that is a seventh darker, under light that changed."""
    rgb, depth = wall()
    seat = rgb.copy()
    seat[60:120, 80:200] = rgb[60:120, 80:200] * 0.75
    here, there = view(rgb, depth), view(darkened(rgb, power), depth)
    assert other(here, there) < 0.005
    assert other(here, view(darkened(seat, power), depth)) > 0.05


def test_what_does_not_shift_colours_does_not_bend_them():
    """Two rooms in one light, with eight stripes that are more unlike in the one, and as light in the middle."""
    depth, grey = wall()[1], np.geomspace(40, 220, 8)[np.arange(320) // 40]
    middle = float(np.sqrt(40 * 220))
    strong = np.minimum(middle * (grey / middle) ** 1.4, 245)
    here, there = (view(np.broadcast_to(one[None, :, None], (240, 320, 3)), depth) for one in (grey, strong))
    assert other(here, there) > 0.1
    assert other(here, view(np.broadcast_to(0.6 * grey[None, :, None], (240, 320, 3)), depth)) < 0.005


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


def test_colours_that_lie_beside_their_depth_while_a_camera_turns_are_no_others():
    """Stripes twelve pixels of the image, three of 80 compared, beside where they belong; as many enter the view."""
    (rgb, depth), (shifted, _) = wall(), wall(12)
    here, beside = view(rgb, depth), view(shifted, depth)
    assert other_colors(here, beside, HERE, CONFIG.free_space) > 0.1
    assert other_colors(here, beside.turning(np.array([0.0, 1.0, 0.0])), HERE, CONFIG.free_space) <= 3 / 80
    other = view(rgb[..., [2, 0, 1]], depth)
    assert other_colors(here, other.turning(np.array([0.0, 1.0, 0.0])), HERE, CONFIG.free_space) > 0.3


IN_ONE_LIGHT = UsualDifferences(np.array([0.01]), 0.01, 0.02)


def usually(pairs):
    """What is usual of a recording in one light."""
    return IN_ONE_LIGHT._replace(shares=np.full(len(pairs), IN_ONE_LIGHT.shares[0]))


@pytest.fixture
def plaster():
    """Colours of a wall with stripes of three that are nearly grey, and its depth."""
    stripe = (np.arange(320) // 16) % 3
    colors = np.array([(170, 160, 150), (120, 125, 115), (95, 100, 110)], float)
    return np.broadcast_to(colors[stripe], (240, 320, 3)), wall()[1]


def lit_otherwise(rgb):
    """By a lamp on the right, which leaves a tenth of a wall in the shadow of a board."""
    return with_board(rgb * np.linspace(0.6, 1.0, 320)[:, None])


def with_board(rgb):
    darker = rgb.copy()
    darker[60:136, 60:160] *= 0.4
    return darker


def painted(rgb, columns):
    other = rgb.copy()
    other[:, :columns] *= (0.7, 1.0, 1.3)
    return other


def difference(a, b):
    return color_difference(a, b, HERE, CONFIG.free_space)


def test_other_light_changes_most_readings_and_other_things_some_of_them(plaster):
    rgb, depth = plaster
    here = view(rgb, depth)
    lit, things = difference(here, view(lit_otherwise(rgb), depth)), difference(here, view(with_board(rgb), depth))
    assert lit.light_change > 0.03
    assert things.light_change < 0.01
    assert lit.hue_change < 0.05
    assert lit.share > 0.05
    assert things.share > 0.05


@pytest.mark.parametrize(("columns", "changes"), [(160, True), (30, False)])
def test_hues_change_with_the_paint_of_more_than_a_few_readings(plaster, columns, changes):
    rgb, depth = plaster
    assert (difference(view(rgb, depth), view(painted(rgb, columns), depth)).hue_change > 0.08) is changes


def test_a_place_that_is_lit_otherwise_is_no_other_place(plaster):
    """Unless nobody knows what is usual, or hues change, too, or what differs is no light."""
    rgb, depth = plaster
    here, lit = view(rgb, depth), lit_otherwise(rgb)
    relit = PlacedPair(here, view(lit, depth), HERE)
    assert not contradict([relit], usually, CONFIG)
    assert contradict([relit], all_usually(0.01), CONFIG)
    for other in (painted(lit, 160), with_board(rgb)):
        assert contradict([PlacedPair(here, view(other, depth), HERE)], usually, CONFIG)


def test_more_than_light_changes_is_another_place_in_any_light(plaster):
    """Boards on a third of a wall whose light differs by little."""
    rgb, depth = plaster
    lit = rgb * np.linspace(0.8, 1.0, 320)[:, None]
    lit[40:200, 60:220] *= 0.4
    pair = PlacedPair(view(rgb, depth), view(lit, depth), HERE)
    assert contradict([pair], usually, CONFIG)


def test_hues_that_keep_a_place_from_being_believed_do_not_part_it_again(plaster):
    """By a tenth more than light may change, and not by a third."""
    rgb, depth = plaster
    here, there = view(rgb, depth), view(lit_otherwise(rgb), depth)
    measured = difference(here, there)
    usual = UsualDifferences(np.array([0.01]), 0.01, measured.hue_change / SAME_HUES / 1.1)
    pair = PlacedPair(here, there, HERE)
    assert contradict([pair], lambda _: usual, CONFIG)
    assert not contradict([pair], lambda _: usual, CONFIG, PLACED)
    more = usual._replace(hue_change=measured.hue_change / SAME_HUES / 1.3)
    assert contradict([pair], lambda _: more, CONFIG, PLACED)
