"""Whether the colours of two views go together."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from slam.backend.view_checks.color_check import color_correlation, color_difference, other_colors
from tests.support.painted_walls import CONFIG, HERE, lit_otherwise, painted, plaster, view, wall, with_board


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


def test_colours_that_lie_beside_their_depth_while_a_camera_turns_are_no_others():
    """Stripes twelve pixels of the image, three of 80 compared, beside where they belong; as many enter the view."""
    (rgb, depth), (shifted, _) = wall(), wall(12)
    here, beside = view(rgb, depth), view(shifted, depth)
    assert other_colors(here, beside, HERE, CONFIG.free_space) > 0.1
    assert other_colors(here, beside.turning(np.array([0.0, 1.0, 0.0])), HERE, CONFIG.free_space) <= 3 / 80
    other = view(rgb[..., [2, 0, 1]], depth)
    assert other_colors(here, other.turning(np.array([0.0, 1.0, 0.0])), HERE, CONFIG.free_space) > 0.3


def difference(a, b):
    return color_difference(a, b, HERE, CONFIG.free_space)


def test_other_light_changes_most_readings_and_other_things_some_of_them():
    rgb, depth = plaster()
    here = view(rgb, depth)
    lit, things = difference(here, view(lit_otherwise(rgb), depth)), difference(here, view(with_board(rgb), depth))
    assert lit.light_change > 0.03
    assert things.light_change < 0.01
    assert lit.hue_change < 0.05
    assert lit.share > 0.05
    assert things.share > 0.05


@pytest.mark.parametrize(("columns", "changes"), [(160, True), (30, False)])
def test_hues_change_with_the_paint_of_more_than_a_few_readings(columns, changes):
    rgb, depth = plaster()
    assert (difference(view(rgb, depth), view(painted(rgb, columns), depth)).hue_change > 0.08) is changes
