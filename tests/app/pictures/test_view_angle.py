"""From where a map is looked at: as it is said, or where most is seen."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from app.pictures.view import NAMED, Angle, parse_angle
from app.pictures.view_angle import best_angle, camera_axes, wall_heading
from razer.errors import BadInput
from tests.support.surfaces import box, joined, plate, turned

UP = np.array([0.0, 0.0, 1.0])


@pytest.mark.parametrize("text", ["20", "north", "10,95", "10,-1", "nan,3", "1,2,3", ""])
def test_angles_that_are_none_are_refused(text):
    with pytest.raises(BadInput, match="--angle"):
        parse_angle(text)


def test_angles_are_names_or_degrees():
    assert parse_angle("-30,45") == Angle(-30, 45)
    assert parse_angle("top") == NAMED["top"]
    assert str(parse_angle("12.5,60")) == "12.5,60"
    assert parse_angle(str(Angle(285.0, 38.0))) == Angle(285.0, 38.0)


@pytest.mark.parametrize("turn_deg", [0, 17, 44, 80, 133])
def test_the_front_is_square_to_the_walls(turn_deg):
    turn = Rotation.from_euler("z", turn_deg, degrees=True).as_matrix()
    heading = wall_heading(turned(box((0, 0, 0), (5, 3, 2.5), 1, outwards=False), turn), UP)
    sides = np.abs(turn.T @ heading)
    assert sides.max() == pytest.approx(1, abs=1e-4)
    assert heading @ UP == pytest.approx(0, abs=1e-9)


def test_named_views_look_from_where_they_say():
    front = np.array([1.0, 0.0, 0.0])
    towards = {name: -camera_axes(UP, front, angle)[2] for name, angle in NAMED.items()}
    np.testing.assert_allclose(towards["top"], UP, atol=1e-12)
    assert towards["front"][0] > 0.9
    assert towards["back"][0] < -0.9
    assert towards["right"][1] > 0.9 > -0.9 > towards["left"][1]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_angle_shows_the_things_and_not_the_screen_before_them(side):
    """A screen with two fronts stands beside three things: they are seen from the other side of it alone."""
    floor = plate((-3, -3, 0), (6, 0, 0), (0, 6, 0), 1)
    screen = joined(plate((0, -3, 0), (0, 6, 0), (0, 0, 5), 2), plate((0, -3, 0), (0, 0, 5), (0, 6, 0), 2))
    things = [box((side * 0.6 - 0.2, y, 0), (side * 0.6 + 0.2, y + 0.4, 0.4), 3 + i) for i, y in enumerate((-1, 0, 1))]
    front = np.array([1.0, 0.0, 0.0])
    angle = best_angle(joined(floor, screen, *things), UP, front, [3, 4, 5])
    assert side * -camera_axes(UP, front, angle)[2][0] > 0.2


def test_what_is_left_out_hides_nothing():
    floor, thing = plate((-2, -2, 0), (4, 0, 0), (0, 4, 0), 1), box((0.8, -0.2, 0), (1.2, 0.2, 0.4), 3)
    hood = box((0.4, -0.6, 0.1), (1.6, 0.6, 1.2), 2)
    mesh = joined(floor, thing, hood)
    front = np.array([1.0, 0.0, 0.0])
    same = best_angle(joined(floor, thing), UP, front, [3])
    assert best_angle(mesh, UP, front, [3], mesh.instances == 2) == same
