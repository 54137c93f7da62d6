"""Arrangement: what placement notes as the truth of relations, and that it is read back from the truth folder."""

from __future__ import annotations

import numpy as np
import pytest

from data_tools.synthetic.layout.arrangement import Arrangement
from data_tools.synthetic.layout.building import Room, flat
from data_tools.synthetic.layout.placement import Placer
from data_tools.synthetic.scenes.living_room import living_room
from data_tools.synthetic.shapes.primitives import block
from data_tools.synthetic.shapes.thing import Thing, tinted
from data_tools.synthetic.synthetic_scene import SCENES
from data_tools.truth.truth_folder import read_relations
from razer.errors import BadInput

PAINT = tinted("smooth", (120.0, 120.0, 120.0))
ROOM = Room((0, 0), (4, 4))


def thing(name, size, z=0.0):
    return Thing(name, (block(0, 0, z, size, PAINT),))


def placer():
    made = Placer(np.random.default_rng(0))
    made.add(Thing("floor", (flat((0, 0, 0), (4, 0, 0), (0, 4, 0), PAINT),)))
    made.add(Thing("wall", (flat((4, 0, 0), (-4, 0, 0), (0, 0, 2.5), PAINT),)))
    return made


def test_floor_wall_and_furniture_are_noted_as_things_are_placed():
    world = placer()
    sideboard = world.against(ROOM, "south", thing("cabinet", (1.0, 0.4, 0.8)), 2.0)
    world.against(ROOM, "south", thing("picture", (0.5, 0.03, 0.4)), 2.0, z=1.4)
    world.on_floor(ROOM, thing("table", (0.8, 0.8, 0.7)), 2.0, 2.5)
    assert sideboard is not None
    world.on_top(sideboard, thing("cup", (0.08, 0.08, 0.1)))
    expected = {(3, "on", 1), (3, "against", 2), (4, "against", 2), (5, "on", 1), (6, "on", 3)}
    assert set(world.relations) == expected


@pytest.mark.parametrize(
    ("name", "rim", "relation"), [("crate", 0.3, "in"), ("crate", 0.02, "on"), ("tray", 0.3, "on")]
)
def test_what_stands_below_the_rim_of_a_container_is_in_it(name, rim, relation):
    container, cup = thing(name, (0.5, 0.5, rim)), thing("cup", (0.08, 0.08, 0.1))
    arrangement = Arrangement([container, cup])
    arrangement.rests(cup, container)
    assert arrangement.relations == [(2, relation, 1)]


@pytest.mark.parametrize("scene", sorted(SCENES))
def test_whatever_stands_in_a_scene_is_carried_by_one_thing(scene):
    world = SCENES[scene](3)
    carried = [a for a, relation, _ in world.relations if relation in ("on", "in")]
    assert len(carried) == len(set(carried)) > 10
    shell = {number for number, thing in world.things.items() if thing.class_name in ("floor", "wall", "ceiling")}
    assert {a for a, _, _ in world.relations} == world.things.keys() - shell


def test_the_demo_room_has_books_in_its_shelf():
    layout = living_room(0)
    named = {(layout.things[a].class_name, r, layout.things[b].class_name) for a, r, b in layout.relations}
    assert {
        ("book", "in", "shelf"),
        ("cup", "on", "table"),
        ("chair", "on", "floor"),
        ("door", "against", "wall"),
    } < named


def test_a_relations_file_that_is_none_is_refused_by_name(tmp_path):
    path = tmp_path / "relations.json"
    assert read_relations(path) is None
    path.write_text('[{"a": 3, "relation": "on"}]')
    with pytest.raises(BadInput, match=r"relations\.json"):
        read_relations(path)
