"""Light maps of furnished rooms, and frames under them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from data_tools.synthetic.layout.building import Room, shell
from data_tools.synthetic.layout.finishes import finish, warm_floor
from data_tools.synthetic.light.light_map import FULL, light_map
from data_tools.synthetic.objects.furniture.wall_mounted import window
from data_tools.synthetic.rendering.ray_renderer import RayRenderer, scene_of
from data_tools.synthetic.shapes.primitives import block
from data_tools.synthetic.shapes.thing import Thing, tinted
from razer.frame import Intrinsics

CAMERA = Intrinsics(80, 60, 60.0, 60.0, 39.5, 29.5)
WHITE = tinted("smooth", (235.0, 235.0, 235.0), 0.0)
# From the south-west corner at eye height, looking to the north-east and down.
_FORWARD = np.array([0.62, 0.62, -0.48]) / np.linalg.norm([0.62, 0.62, -0.48])
_RIGHT = np.array([0.7071, -0.7071, 0.0])
POSE = np.eye(4)
POSE[:3, :3] = np.stack([_RIGHT, np.cross(_FORWARD, _RIGHT), _FORWARD], axis=1)
POSE[:3, 3] = 0.4, 0.4, 1.6


def room_with(*things: Thing) -> dict[int, Thing]:
    rng = np.random.default_rng(0)
    look = replace(finish(warm_floor(rng), rng), floor=WHITE)
    return dict(enumerate([*shell(Room((0, 0), (4, 3)), (), look), *things], start=1))


def test_a_table_shades_the_floor_below_it() -> None:
    table = Thing("table", (block(2.4, 1.8, 0.72, (1.2, 0.8, 0.03), WHITE),))
    seen = RayRenderer(room_with(table), CAMERA).render(POSE)
    bare = RayRenderer(room_with(), CAMERA).render(POSE)
    floor = (seen.ids == 1) & (bare.ids == 1)
    darker = bare.rgb.mean(axis=2) - seen.rgb.mean(axis=2)
    u, v = np.meshgrid(np.arange(80), np.arange(60))
    rays = np.stack([(u - 39.5) / 60, (v - 29.5) / 60, np.ones_like(u)], axis=-1) @ POSE[:3, :3].T
    place = POSE[:2, 3] + rays[..., :2] * bare.depth[..., None]
    below = floor & (np.abs(place - (2.4, 1.8)) < (0.5, 0.3)).all(axis=2)
    away = floor & (np.linalg.norm(place - (2.4, 1.8), axis=2) > 1.6)
    assert below.sum() > 10
    assert away.sum() > 10
    assert darker[below].mean() > 12
    assert abs(darker[away].mean()) < 8


def test_windows_light_the_day_and_are_dark_in_the_evening() -> None:
    pane = window(np.random.default_rng(1)).placed(2.0, 3.0, 0.9, 180)
    shown = {}
    for light in ("day", "evening"):
        seen = RayRenderer(room_with(pane), CAMERA, light=light).render(POSE)
        sky = (seen.ids == 7) & (seen.rgb[..., 2] >= seen.rgb[..., 0])
        shown[light] = seen.rgb[sky].mean() if sky.any() else 0.0
    assert shown["day"] > shown["evening"] + 80


def test_the_same_world_is_lit_once_and_another_anew() -> None:
    things = room_with()
    scene = scene_of(things)
    first = light_map(things, scene, "day")
    assert light_map(dict(things), scene, "day") is first
    assert light_map(things, scene, "evening") is not first
    other = room_with(Thing("box", (block(1, 1, 0, (0.4, 0.4, 0.4), WHITE),)))
    assert light_map(other, scene_of(other), "day") is not first


def test_no_face_is_without_light_and_most_light_is_that_of_the_colours_shown() -> None:
    things = room_with()
    light = light_map(things, scene_of(things), "day")
    lit = light.image[light.image > 0]
    assert lit.min() > 0.1 * FULL
    assert 0.6 * FULL < np.median(lit) < 1.2 * FULL
