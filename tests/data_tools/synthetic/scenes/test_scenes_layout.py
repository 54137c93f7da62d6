"""The synthetic scenes: nothing stands in anything, nothing floats, and the camera keeps its distance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from functools import cache
from itertools import combinations

import numpy as np
import open3d as o3d
import pytest

from data_tools.synthetic.camera.hand_held import walk_round
from data_tools.synthetic.camera.walk import usual_frames, walk
from data_tools.synthetic.layout.building import Room, block_walls, walls
from data_tools.synthetic.layout.placement import Placer, solid_boxes
from data_tools.synthetic.rendering.ray_renderer import scene_of
from data_tools.synthetic.scenes.living_room import living_room
from data_tools.synthetic.scenes.world import World
from data_tools.synthetic.shapes.primitives import block
from data_tools.synthetic.shapes.solids import quad_normals
from data_tools.synthetic.shapes.thing import Thing, tinted
from data_tools.synthetic.synthetic_scene import SCENES, SyntheticScene
from razer.vocabulary import vocabulary

STUFF = {"wall", "floor", "ceiling"}
GREY = tinted("smooth", (200.0, 200.0, 200.0))
# Least number of things, of their classes, and how many chairs, None = any number.
LEAST = {
    "room": (30, 25, 6),
    "apartment": (100, 60, 6),
    "corridor-loop": (28, 18, 0),
    "tabletop": (25, 22, 0),
    "warehouse": (90, 25, 0),
    "corridors": (80, 12, None),
    "twin-rooms": (60, 25, 12),
}
CASES = [(name, seed) for name in SCENES for seed in ((0, 3) if name != "warehouse" else (3,))]


@cache
def world(name: str, seed: int) -> World:
    return SCENES[name](seed)


@cache
def poses(name: str, seed: int) -> np.ndarray:
    stations = world(name, seed).stations
    return walk(stations, usual_frames(stations), seed)


def solid_things(things: Mapping[int, Thing]) -> dict[int, Thing]:
    return {number: thing for number, thing in things.items() if thing.class_name not in STUFF}


def overlaps(things: Mapping[int, Thing]) -> set[tuple[int, int]]:
    """Pairs of things of which the boxes of two solids share more than a centimetre along every axis."""
    boxes = {number: solid_boxes(thing) for number, thing in solid_things(things).items()}
    found = set()
    for one, two in combinations(boxes, 2):
        a, b = boxes[one], boxes[two]
        if (np.minimum(a[:, 1].max(axis=0), b[:, 1].max(axis=0)) < np.maximum(a[:, 0].min(0), b[:, 0].min(0))).any():
            continue
        shared = np.minimum(a[:, None, 1], b[:, 1]) - np.maximum(a[:, None, 0], b[:, 0])
        if (shared > 0.01).all(axis=2).any():
            found.add((one, two))
    return found


def floating(things: Mapping[int, Thing]) -> set[int]:
    """Things with nothing within 5 mm below their lowest points that do not touch a wall either."""
    wall = scene_of({number: thing for number, thing in things.items() if thing.class_name == "wall"})
    found = set()
    for number, thing in solid_things(things).items():
        points = np.concatenate([solid.quads for solid in thing.solids]).reshape(-1, 3).astype(np.float32)
        feet = points[points[:, 2] < points[:, 2].min() + 0.002]
        rays = np.hstack([feet + np.float32([0, 0, 0.004]), np.tile(np.float32([0, 0, -1]), (len(feet), 1))])
        others = scene_of({n: t for n, t in things.items() if n != number})
        below = others.cast_rays(o3d.core.Tensor(rays))["t_hit"].numpy() - 0.004
        if below.min() > 0.005 and wall.compute_distance(o3d.core.Tensor(points)).numpy().min() > 0.006:
            found.add(number)
    return found


@pytest.mark.parametrize(("name", "seed"), CASES)
def test_nothing_stands_in_another_thing(name: str, seed: int) -> None:
    assert overlaps(world(name, seed).things) == set()


@pytest.mark.parametrize(("name", "seed"), CASES)
def test_everything_stands_on_something_or_hangs_on_a_wall(name: str, seed: int) -> None:
    assert floating(world(name, seed).things) == set()


def test_the_checks_notice_a_thing_that_is_moved() -> None:
    things = world("tabletop", 0).things
    cups = [number for number, thing in things.items() if thing.class_name == "cup"]
    raised = {**things, cups[0]: things[cups[0]].placed(0, 0, 0.02)}
    assert floating(raised) == {cups[0]}
    low, high = (np.array(things[cup].bounds).mean(axis=0) for cup in cups[:2])
    assert overlaps({**things, cups[0]: things[cups[0]].placed(*(high - low)[:2])}) == {(cups[0], cups[1])}


@pytest.mark.parametrize(("name", "seed"), CASES)
def test_there_are_many_things_of_many_known_classes(name: str, seed: int) -> None:
    things = world(name, seed).things
    count = Counter(thing.class_name for thing in solid_things(things).values())
    least, classes, chairs = LEAST[name]
    assert sum(count.values()) >= least
    assert len(count) >= classes
    assert chairs in (None, count["chair"])
    assert set(count) | STUFF <= set(vocabulary("scannet200").by_name)
    assert sorted(things) == list(range(1, len(things) + 1))


@pytest.mark.parametrize("name", ["room", "apartment"])
def test_the_six_chairs_are_equal_and_stand_round_the_table(name: str) -> None:
    things = world(name, 3).things.values()
    chairs = [thing for thing in things if thing.class_name == "chair"]
    sizes = [np.linalg.norm(np.diff(np.concatenate([s.quads for s in c.solids]), axis=1), axis=2) for c in chairs]
    for size in sizes[1:]:
        np.testing.assert_allclose(size, sizes[0], atol=1e-9)
    table = next(thing for thing in things if thing.class_name == "table")
    centers = [np.mean(chair.bounds, axis=0) - np.mean(table.bounds, axis=0) for chair in chairs]
    assert all(np.hypot(*center[:2]) < 1.4 for center in centers)
    quadrants = Counter((bool(c[0] > 0.2) - bool(c[0] < -0.2), bool(c[1] > 0.2) - bool(c[1] < -0.2)) for c in centers)
    assert len(quadrants) == 6


@pytest.mark.parametrize("seed", [1, 2, 9])
def test_the_camera_keeps_out_of_furniture_near_a_table_and_in_the_demo_room(seed: int) -> None:
    walks = {"tabletop": (world("tabletop", seed).things, poses("tabletop", seed))}
    walks["demo"] = (living_room(seed).things, walk_round(240, (1.75, 1.3), seed))
    for things, path in walks.values():
        centers = np.ascontiguousarray(path[:, :3, 3], np.float32)
        assert scene_of(things).compute_distance(o3d.core.Tensor(centers)).numpy().min() > 0.25


@pytest.mark.parametrize(("name", "seed"), CASES)
def test_the_camera_is_carried_slowly_upright_and_far_from_everything(name: str, seed: int) -> None:
    path = poses(name, seed)
    centers = np.ascontiguousarray(path[:, :3, 3])
    distance = scene_of(world(name, seed).things).compute_distance(o3d.core.Tensor(centers.astype(np.float32)))
    assert distance.numpy().min() > 0.25
    assert np.linalg.norm(np.diff(centers, axis=0), axis=1).max() * 15 < 0.52
    turn = np.einsum("nij,nij->n", path[1:, :3, :3], path[:-1, :3, :3])
    assert np.degrees(np.arccos(np.clip((turn - 1) / 2, -1, 1))).max() * 15 < 60
    # The camera's y axis points down, and mostly it looks a little down itself.
    assert path[:, 2, 1].max() < -0.7
    assert -0.6 < np.median(path[:, 2, 2]) < -0.05


@pytest.mark.parametrize("seed", [0, 3, 8])
def test_the_corridor_leads_once_round_and_back(seed: int) -> None:
    path = poses("corridor-loop", seed)
    centers = path[:, :2, 3]
    assert np.linalg.norm(np.diff(centers, axis=0), axis=1).sum() >= 25
    assert np.linalg.norm(path[0, :3, 3] - path[-1, :3, 3]) <= 0.3
    assert np.degrees(np.arccos(path[0, :3, 2] @ path[-1, :3, 2])) < 8
    middle = (centers.min(axis=0) + centers.max(axis=0)) / 2
    angles = np.unwrap(np.arctan2(*(centers - middle).T[::-1]))
    assert angles[-1] - angles[0] == pytest.approx(2 * np.pi, abs=0.2)


def test_three_places_of_the_corridor_look_alike() -> None:
    things = world("corridor-loop", 0).things.values()

    def place(door: Thing) -> tuple:
        """What stands within 2 m of a door on its side, by its distance to it."""
        near = [t for t in things if t.class_name in ("picture", "plant")]
        offsets = [(t.class_name, np.mean(t.bounds, axis=0) - np.mean(door.bounds, axis=0)) for t in near]
        return tuple(sorted((n, round(float(np.hypot(*o[:2])), 2)) for n, o in offsets if np.hypot(*o[:2]) < 1.5))

    shapes = Counter((len(t.solids), place(t)) for t in things if t.class_name == "door")
    assert max(shapes.values()) == 3


@pytest.mark.parametrize(("name", "seed"), CASES)
def test_walls_that_lie_in_one_plane_and_touch_differ_in_paint(name: str, seed: int) -> None:
    sheets = [t for t in world(name, seed).things.values() if t.class_name == "wall"]
    for one, two in combinations(sheets, 2):
        (low, high), (least, most) = one.bounds, two.bounds
        touching = (np.minimum(high, most) >= np.maximum(low, least) - 0.05).all()
        normals = [quad_normals(t.solids[0].quads)[0] for t in (one, two)]
        if touching and normals[0] @ normals[1] > 0.99:
            assert one.solids[0].material != two.solids[0].material


def test_walls_face_the_room_and_those_of_a_block_face_away_from_it() -> None:
    room = Room((1, 2), (4, 7))
    for made, sign in ((walls(room, (), [GREY] * 4), 1), (block_walls(room, [GREY] * 4), -1)):
        for wall in made:
            (quad,) = wall.solids[0].quads
            towards = np.array([*room.center, 1.3]) - quad.mean(axis=0)
            assert sign * towards @ quad_normals(quad[None])[0] > 1


def test_a_shelf_is_loaded_level_by_level_and_only_where_things_fit() -> None:
    placer = Placer(np.random.default_rng(0))
    boards = [block(0, 0, z, (0.8, 0.3, 0.02), GREY) for z in (0.0, 0.5, 1.0)]
    shelf = placer.add(Thing("shelf", tuple(boards)))
    cube = Thing("box", (block(0, 0, 0, (0.2, 0.2, 0.2), GREY),))
    for level, height in enumerate((1.02, 0.52, 0.02)):
        put = placer.on_top(shelf, cube, level=level)
        assert put is not None
        assert put.bounds[0][2] == pytest.approx(height, abs=1e-5)
        assert (np.abs(put.bounds)[:, :2].max(axis=0) <= (0.4, 0.15)).all()
    assert placer.on_top(shelf, Thing("box", (block(0, 0, 0, (0.2, 0.4, 0.2), GREY),)), yaw_deg=0) is None
    assert placer.on_top(shelf, cube, level=3) is None
    full = [placer.on_top(shelf, cube, yaw_deg=0) for _ in range(8)]
    assert 1 <= sum(put is not None for put in full) <= 3


def test_the_walk_through_the_room_sees_nearly_everything() -> None:
    room = SyntheticScene("room", 0, 60, 160, 120)
    truth = room.truth(0.04)
    seen = set(np.unique(truth.instances[truth.visible]))
    assert len(set(room.classes) - seen) <= 2


def test_of_twin_rooms_one_is_the_other_moved_but_for_colours_and_a_piece_in_each() -> None:
    things = list(world("twin-rooms", 1).things.values())
    floors = [thing for thing in things if thing.class_name == "floor"][:2]
    apart = float(floors[1].bounds[0][0] - floors[0].bounds[0][0])

    def pieces(floor: Thing, shift: float) -> Counter[tuple]:
        """Class and corners, to the millimetre, of what is in a room, moved by so much."""
        low, high = floor.bounds
        inside = [t for t in things if (np.mean(t.bounds, 0)[:2] > low[:2] - 0.01).all()]
        inside = [t for t in inside if (np.mean(t.bounds, 0)[:2] < high[:2] + 0.01).all()]
        corners = [np.add(np.concatenate([s.quads for s in t.solids]), (shift, 0, 0)) for t in inside]
        return Counter(
            (t.class_name, *np.rint(1000 * c).ravel().tolist()) for t, c in zip(inside, corners, strict=True)
        )

    west, east = pieces(floors[0], apart), pieces(floors[1], 0.0)
    assert [name for name, *_ in west - east] == ["suitcase"]
    assert [name for name, *_ in east - west] == ["laundry basket"]
    assert (west & east).total() > 35


def test_what_is_repeated_in_the_twin_room_is_repeated_with_its_relations() -> None:
    twins = world("twin-rooms", 1)
    x = {number: float(np.mean(thing.bounds, axis=0)[0]) for number, thing in twins.things.items()}
    furniture = {number for number, thing in twins.things.items() if thing.class_name not in STUFF}
    rests = [(one, relation, other) for one, relation, other in twins.relations if {one, other} <= furniture]
    assert len(rests) > 20
    # What stands on something is above it, in either room.
    assert all(abs(x[one] - x[other]) < 1 for one, _, other in rests)
    on_floors = {other for _, _, other in twins.relations if twins.things[other].class_name == "floor"}
    assert len(on_floors) == 3
