"""What is held against keyframes that are placed among others: their colours, beside those of their own chains."""

from __future__ import annotations

import numpy as np
import pytest

from razer.frame import Frame, Intrinsics
from slam.backend.pose_graph import PoseEdge, PoseGraph
from slam.backend.submaps.placement_check import PlacedPair, PlacementCheck
from slam.backend.view_checks.usual_colors import LEAST_USUAL, NOISE
from slam.config import SlamConfig
from slam.frontend.features import no_features
from slam.frontend.keyframes import STILL, Keyframes, View

CAMERA = Intrinsics(160, 120, 130.0, 130.0, 79.5, 59.5)
CONFIG = SlamConfig()
COLORS = np.array([(200, 60, 50), (60, 160, 70), (50, 70, 190)], np.uint8)
STEP_PIXELS, AWAY_M = 6, 2.0
STEP_M = STEP_PIXELS * AWAY_M / CAMERA.fx
CERTAIN = 1e9 * np.eye(6)
NO_TIES = np.zeros((0, 2), np.int64)
ROWS, WIDTH = slice(20, 80), 50  # of what covers a sixth of a view


def view(number, step, covered_from=None):
    """A wall of broad stripes, from a camera that moved aside by so many steps; dark from a column of the view on."""
    stripe = (np.arange(160) + STEP_PIXELS * step) // 20 % 3
    rgb = np.array(np.broadcast_to(COLORS[stripe], (120, 160, 3)))
    if covered_from is not None:
        rgb[ROWS, covered_from : covered_from + WIDTH] = (10, 40, 30)
    frame = Frame(number, float(number), rgb, np.full((120, 160), AWAY_M, np.float32), CAMERA)
    return View.of(frame, no_features(np.zeros((0, 32), np.uint8)), STILL, CONFIG)


def aside(step):
    pose = np.eye(4)
    pose[0, 3] = STEP_M * step
    return pose


def glare(step):
    """A reflection that comes and goes."""
    return 40 if step % 2 else None


def board(step):
    """Something on the wall, of another colour."""
    return 90 - STEP_PIXELS * step


def rare_glare(step):
    """One that is there in every seventh view."""
    return None if step % 7 else 40


def nothing(_):
    """A plain wall."""


def walls(of_standing, of_placed, n_placed):
    """A chain of twenty keyframes in front of a wall, and one of some more."""
    keyframes, graph = Keyframes(), PoseGraph()
    for number in range(20 + n_placed):
        chain = int(number >= 20)
        step = number - 20 * chain
        covered_from = (of_placed if chain else of_standing)(step)
        keyframes.add(view(number, step, covered_from), aside(step), chain, 0.0, chain)
        graph.add_keyframe(number, aside(step), unanchored=number == 20)
        if number not in (0, 20):
            graph.add_edge(PoseEdge(number - 1, number, aside(1), CERTAIN, is_odometry=True))
        for back in (6, 12) if not chain else ():
            if number >= back:
                graph.add_edge(PoseEdge(number - back, number, aside(back), CERTAIN))
    return PlacementCheck(keyframes, graph, CONFIG)


@pytest.mark.parametrize(("covered_from", "contradicts"), [(glare, False), (board, True)])
def test_colours_that_differ_within_a_chain_may_differ_beside_others(covered_from, contradicts):
    """A chain of seven keyframes in front of a wall that another chain of twenty saw without."""
    check = walls(nothing, covered_from, 7)
    assert check.contradicts(list(range(20, 27)), np.arange(20), np.eye(4), NO_TIES) is contradicts


@pytest.mark.parametrize(("of_standing", "contradicts"), [(rare_glare, False), (nothing, True)])
def test_a_keyframe_that_tells_nothing_of_its_chain_may_differ_as_much_as_some_do(of_standing, contradicts):
    """One with a reflection, beside keyframes of which some have it, or none."""
    check = walls(of_standing, lambda _: 40, 1)
    assert check.contradicts([20], np.arange(20), np.eye(4), NO_TIES, strictly=True) is contradicts


@pytest.mark.parametrize(("of_placed", "times"), [(nothing, 1), (glare, 30)])
def test_what_is_usual_is_told_with_noise_and_without(of_placed, times):
    """Of clean walls noise is all there is; beside a chain with a reflection much may differ, and noise is nothing."""
    check = walls(nothing, of_placed, 7)
    usual = check._usual_differences([PlacedPair.of(check.keyframes, 20, number, np.eye(4)) for number in range(20)])
    assert usual.shares.min() >= times * LEAST_USUAL
    assert usual.bare_shares.min() >= times * NOISE
    if times == 1:
        np.testing.assert_array_equal(usual.shares, LEAST_USUAL)
        np.testing.assert_array_equal(usual.bare_shares, NOISE)
    else:
        np.testing.assert_allclose(usual.shares, usual.bare_shares, rtol=0.05)
