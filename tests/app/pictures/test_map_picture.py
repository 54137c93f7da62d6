"""Pictures of small scenes: upright, into rooms, smooth at edges, in the colours given, on white or on nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.pictures.camera import fitted_camera
from app.pictures.map_picture import Scene, draw, render
from app.pictures.style_colors import VertexColors
from app.pictures.view import Angle, View
from app.pictures.view_angle import camera_axes
from razer.mesh.labelled_mesh import LabelledMesh
from tests.support.surfaces import box, joined, plate

UP = np.array([0.0, 0.0, 1.0])
SIZE = (320, 240)
RED, BLUE = (220, 40, 40), (40, 60, 220)


def scene(mesh, **more):
    return Scene(mesh, VertexColors.own(mesh), more.pop("up", UP), **more)


def where(pixels, color):
    """Pixels (rows, columns) whose colour is mostly this one, at any brightness."""
    flat = pixels[..., :3].astype(float)
    length = np.linalg.norm(flat, axis=2)
    cosine = flat @ (np.array(color) / np.linalg.norm(color)) / np.maximum(length, 1)
    return np.nonzero((cosine > 0.985) & (length < 430))


@pytest.mark.parametrize("flip", [1.0, -1.0])
def test_what_is_higher_in_the_world_is_higher_in_the_picture(flip):
    floor = plate((-2, -2, 0), (4, 0, 0), (0, 4, 0), 1, RED)
    lamp = plate((-0.3, -0.3, 2), (0.6, 0, 0), (0, 0.6, 0), 2, BLUE)
    mesh = joined(floor, lamp)
    vertices = mesh.vertices @ np.diag([1.0, flip, flip]).astype(np.float32)  # a world whose z points down
    turned = replace(mesh, vertices=vertices.astype(np.float32))
    picture = draw(scene(turned, up=np.array([0.0, 0.0, flip])), View(size=SIZE))
    low, high = where(picture.pixels, RED)[0], where(picture.pixels, BLUE)[0]
    assert len(low) > 1000
    assert len(high) > 50
    assert high.mean() < low.mean()


@pytest.mark.parametrize("angle", [Angle(30, 40), Angle(200, 60), Angle(0, 90)])
def test_one_looks_into_a_closed_room(angle):
    room = box((0, 0, 0), (5, 4, 2.6), 1, outwards=False)
    thing = box((2, 1.5, 0), (3, 2.5, 0.8), 2, color=RED)
    picture = draw(scene(joined(room, thing)), View(angle, SIZE))
    assert len(where(picture.pixels, RED)[0]) > 400


def test_what_is_left_out_is_not_drawn_and_not_room_for():
    thing, tower = box((0, 0, 0), (1, 1, 1), 1, color=RED), box((0, 0, 0), (1, 1, 9), 2, color=BLUE)
    mesh = joined(thing, tower)
    picture = draw(scene(mesh, left_out=mesh.instances == 2), View(Angle(20, 30), SIZE))
    alone = draw(scene(thing), View(Angle(20, 30), SIZE))
    np.testing.assert_array_equal(picture.pixels, alone.pixels)


def test_the_picture_has_the_size_asked_for_or_is_cropped_to_the_map():
    wall = scene(plate((0, 0, 0), (0, 8, 0), (0, 0, 1), 1, RED))
    assert draw(wall, View(Angle(0, 0), SIZE)).pixels.shape == (240, 320, 3)
    cropped = draw(wall, View(Angle(0, 0))).pixels
    assert cropped.shape[1] == 1600
    assert cropped.shape[0] < 500
    rows, columns = np.nonzero((cropped < 250).any(axis=2))
    free = [rows.min(), cropped.shape[0] - 1 - rows.max(), columns.min(), cropped.shape[1] - 1 - columns.max()]
    assert min(free) > 20
    assert max(free) < 90


def test_a_transparent_ground_is_nothing_and_edges_are_smooth():
    mesh = box((0, 0, 0), (1, 1, 1), 1, color=RED)
    clear = draw(scene(mesh), View(Angle(30, 30), SIZE, "transparent")).pixels
    white = draw(scene(mesh), View(Angle(30, 30), SIZE)).pixels
    opacity = clear[..., 3]
    assert set(opacity[:5].ravel()) == {0}
    assert (opacity == 255).sum() > 5000
    partly = (opacity > 0) & (opacity < 255)
    assert 50 < partly.sum() < 3000
    share = opacity[..., None] / 255
    np.testing.assert_allclose(share * clear[..., :3] + 255 * (1 - share), white, atol=2)


def test_colours_are_those_given_but_for_the_light():
    mesh = joined(plate((0, 0, 0), (1, 0, 0), (0, 1, 0), 1, RED), plate((1, 0, 0), (1, 0, 0), (0, 1, 0), 2, BLUE))
    camera = fitted_camera(camera_axes(UP, np.array([1.0, 0, 0]), Angle(0, 90)), mesh.vertices, SIZE, 10)
    shown = render(scene(mesh), camera)
    for number, color in ((1, RED), (2, BLUE)):
        own = np.median(shown.color[shown.instances == number], axis=0)
        np.testing.assert_allclose(own / np.linalg.norm(own), np.array(color) / np.linalg.norm(color), atol=0.01)
        assert 0.8 < np.linalg.norm(own) / np.linalg.norm(color) < 1.25
    assert (shown.instances[shown.opacity == 0] == -1).all()


def test_corners_are_darker_than_open_floor():
    floor, wall = plate((0, 0, 0), (4, 0, 0), (0, 4, 0), 1), plate((0, 0, 0), (0, 4, 0), (0, 0, 2), 2)
    mesh = joined(floor, wall)
    camera = fitted_camera(camera_axes(UP, np.array([1.0, 0, 0]), Angle(0, 50)), mesh.vertices, SIZE, 10)
    shown = render(scene(mesh), camera)

    def brightness(x):
        column, row = camera.project(np.array([[x, 2.0, 0.0]]))[0].astype(int)
        assert shown.instances[row, column] == 1
        return shown.color[row, column].mean()

    assert brightness(0.05) < 0.93 * brightness(2.0)


def test_names_are_written_where_things_are():
    mesh = joined(plate((-2, -2, 0), (4, 0, 0), (0, 4, 0), 1), box((0, 0, 0), (1, 1, 1), 5, color=BLUE))
    view = View(Angle(30, 40), (640, 480))
    bare, named = draw(scene(mesh), view), draw(scene(mesh, names={5: "box", 9: "nowhere"}), view)
    assert (bare.labelled, named.labelled) == ((), (5,))
    rows, columns = np.nonzero((bare.pixels != named.pixels).any(axis=2))
    at = np.array(where(bare.pixels, BLUE)).mean(axis=1)
    assert np.hypot(rows.mean() - at[0], columns.mean() - at[1]) < 120
    text = named.pixels[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
    assert (text.min(axis=2) > 240).mean() > 0.2  # the pill
    assert (text.max(axis=2) < 70).sum() > 20  # dark letters


@pytest.mark.parametrize("background", ["white", "transparent"])
def test_an_empty_map_is_bare_ground(background):
    picture = draw(scene(LabelledMesh.empty()), View(None, SIZE, background))
    assert picture.pixels.shape == (240, 320, 3 if background == "white" else 4)
    assert (picture.pixels == (255 if background == "white" else 0)).all()


def test_a_picture_is_the_same_every_time():
    mesh = joined(box((0, 0, 0), (5, 4, 2.6), 1, outwards=False), box((2, 1.5, 0), (3, 2.5, 0.8), 2, color=RED))
    first, again = (draw(scene(mesh, names={2: "box"}, wanted=[2]), View(size=SIZE)) for _ in range(2))
    assert first.angle == again.angle
    np.testing.assert_array_equal(first.pixels, again.pixels)
