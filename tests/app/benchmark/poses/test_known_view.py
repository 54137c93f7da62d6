"""What of a view is known: by hand-made walls, and against a slow count."""

from __future__ import annotations

import numpy as np
import pytest

from app.benchmark.poses.known_view import CELL_M, KnownCells, seen_cells
from razer.frame import Frame, Intrinsics

CAMERA = Intrinsics(160, 120, 130.0, 130.0, 79.5, 59.5)


def wall(distance_m: float = 2.03) -> Frame:
    depth = np.full((120, 160), distance_m, np.float32)
    return Frame(0, 0.0, np.zeros((120, 160, 3), np.uint8), depth, CAMERA)


def shifted(x: float) -> np.ndarray:
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


def share_of_shifted(x: float) -> float:
    known = KnownCells()
    known.add(seen_cells(wall(), np.eye(4)))
    return known.share(seen_cells(wall(), shifted(x)))


def test_of_a_wall_seen_from_beside_that_share_is_known_which_both_views_show():
    width_m = 160 / 130 * 2.03
    assert share_of_shifted(0) == 1
    for x in (0.5, 1.0, 2.0):
        assert share_of_shifted(x) == pytest.approx(1 - x / width_m, abs=0.06)
    assert share_of_shifted(3.0) == 0


def test_the_same_place_seen_from_elsewhere_is_known():
    """A wall 2 m ahead, and from 1 m nearer to it: all that is seen then was seen before."""
    known = KnownCells()
    known.add(seen_cells(wall(), np.eye(4)))
    nearer = np.eye(4)
    nearer[2, 3] = 1.0
    assert known.share(seen_cells(wall(1.03), nearer)) == 1
    nearer[2, 3] = 0.5
    assert known.share(seen_cells(wall(1.03), nearer)) == 0


def test_cells_are_those_of_a_slow_count():
    rng = np.random.default_rng(0)
    depth = rng.uniform(0.5, 5, (120, 160)).astype(np.float32) * (rng.random((120, 160)) < 0.7)
    pose = shifted(-31.7)
    slow = set()
    for v in range(0, 120, 2):
        for u in range(0, 160, 2):
            z = float(depth[v, u])
            if z > 0:
                point = ((u - 79.5) / 130 * z - 31.7, (v - 59.5) / 130 * z, z)
                slow.add(tuple(int(np.floor(x / CELL_M)) for x in point))
    cells = seen_cells(Frame(0, 0.0, wall().rgb, depth, CAMERA), pose)
    assert len(cells) == len(slow) == len(set(cells.tolist()))


def test_nothing_is_known_of_nothing():
    nothing = Frame(0, 0.0, wall().rgb, np.zeros((120, 160), np.float32), CAMERA)
    assert len(seen_cells(nothing, np.eye(4))) == 0
    assert KnownCells().share(seen_cells(nothing, np.eye(4))) == 0
