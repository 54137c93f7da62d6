"""Ways that a camera can be carried, and walks along them."""

from __future__ import annotations

import numpy as np
import pytest

from data_tools.synthetic.camera.camera_path import CameraPath
from data_tools.synthetic.camera.walk import Station, usual_frames, walk
from data_tools.synthetic.layout.free_space import CLEAR_M, EmptyCells, FreeSpace
from data_tools.synthetic.shapes.primitives import block
from data_tools.synthetic.shapes.thing import Thing, tinted

GREY = tinted("smooth", (200.0, 200.0, 200.0))
# A hall of 6 x 4 m with a wall across its middle that leaves a gap of 1 m at the far end, and a low table beyond.
OUTLINE = [block(0, s * 2, 0, (6, 0.1, 2.5), GREY) for s in (-1, 1)]
OUTLINE += [block(s * 3, 0, 0, (0.1, 4, 2.5), GREY) for s in (-1, 1)]
ACROSS = block(0, -0.5, 0, (0.1, 3, 2.5), GREY)
TABLE = block(1.5, 0, 0, (1, 1, 0.8), GREY)


def hall(*solids: object) -> FreeSpace:
    return FreeSpace(EmptyCells.among([Thing("wall", (*OUTLINE, *solids))]), (-2, -1))


def length(way: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())


def test_a_way_leads_through_the_gap_and_keeps_its_distance() -> None:
    way = hall(ACROSS, TABLE).route((-2, -1), (2, -1))
    assert way[0] == pytest.approx((-2, -1), abs=0.05)
    assert way[-1] == pytest.approx((2, -1), abs=0.05)
    assert np.linalg.norm(np.diff(way, axis=0), axis=1).max() < 0.15
    crossing = way[np.abs(way[:, 0]).argmin()]
    assert 1 + CLEAR_M - 0.08 < crossing[1] < 2
    # Never near the end of the wall, (0, 1), nor near the outer walls.
    assert np.linalg.norm(way - (0, 1), axis=1).min() > CLEAR_M - 0.08
    assert (np.abs(way) < (2.95 - CLEAR_M + 0.05, 1.95 - CLEAR_M + 0.05)).all()
    assert 5.5 < length(way) < 8


def test_without_the_wall_the_way_is_nearly_straight_and_leads_over_the_table() -> None:
    assert length(hall(TABLE).route((-2, -1), (2, 1))) < 1.12 * np.hypot(4, 2)
    assert hall(TABLE).nearest((1.5, 0)) == pytest.approx((1.5, 0), abs=0.04)


def test_a_place_behind_a_closed_wall_is_not_reached() -> None:
    closed = block(0, 0, 0, (0.1, 4, 2.5), GREY)
    nearest = hall(closed).nearest((2, 0))
    assert nearest[0] == pytest.approx(-0.05 - CLEAR_M, abs=0.1)
    with pytest.raises(ValueError, match="no camera can be"):
        FreeSpace(EmptyCells.among([Thing("wall", tuple(OUTLINE))]), (2.9, 0))


def test_a_tour_looks_ahead_and_across() -> None:
    tour = CameraPath(hall(), (-2, -1))
    tour.go((2, -1))
    for station in tour.stations:
        assert station.target[0] - station.eye[0] > 1.2
        assert station.target[2] < station.eye[2]
    before = len(tour.stations)
    tour.round((-3, -2), (3, 2))
    bearings = [np.arctan2(s.target[1], s.target[0]) for s in tour.stations[before:]]
    assert abs(np.unwrap(bearings)[-1] - np.unwrap(bearings)[0]) == pytest.approx(2 * np.pi, abs=1e-6)
    for station in tour.stations[before:]:
        eye, target = np.array(station.eye[:2]), np.array(station.target[:2])
        assert eye @ target < 0
    # It ends half-way between the middle and the side where it began.
    assert tour.stations[-1].eye[:2] == pytest.approx((0.5 * 3 * 0.8, -0.5 * 2 * 0.6), abs=0.05)


def test_a_walk_with_fewer_frames_leads_past_the_same_places() -> None:
    corners = [(0, 0), (3, 0), (3, 2), (0, 2)]
    stations = [Station((x, y, 1.5), (1.5, 1, 1)) for x, y in corners]
    many = usual_frames(stations)
    path = walk(stations, 2 * many - 1, 4)
    np.testing.assert_allclose(path[::2], walk(stations, many, 4), atol=1e-9)
    # Corners are rounded, ends are not missed by much.
    centers = path[:, :3, 3]
    for corner in ((0, 0, 1.5), (0, 2, 1.5)):
        assert np.linalg.norm(centers - corner, axis=1).min() < 0.15
    assert np.linalg.norm(np.diff(centers, axis=0), axis=1).sum() == pytest.approx(8, abs=0.8)
