"""Styles of pictures: by instance, by class, hits of a query, and which names they bear."""

from __future__ import annotations

import numpy as np
import pytest

from app.pictures.scenes import answer_scene, map_scene
from app.pictures.style_colors import HIT, style_colors
from app.render.palette import HUES, NOBODY, STUFF
from razer.boxes.oriented_box import OrientedBox
from razer.map_object import Hit, MapObject
from razer.panoptic_map import PanopticMap
from tests.support.surfaces import joined, plate

SIZES = {
    1: ("floor", 4.0), 2: ("chair", 1.0), 3: ("table", 2.0), 4: ("chair", 0.6), 5: (None, 1.5), 6: ("ceiling", 3.0),
    7: ("lamp", 0.5), 8: ("floor", 0.4),
}  # fmt: skip


def thing(number, name, n_vertices):
    box = OrientedBox(np.zeros(3), np.eye(3), np.ones(3))
    none = np.zeros((0, 2), np.float32)
    return MapObject(number, name, 0.9, box, n_vertices, n_vertices, 5, 0, 9, none, np.zeros(0))


@pytest.fixture
def panoptic():
    """Plates of the instances above and one of nobody, the larger the more vertices."""
    plates = [plate((3 * i, 0, 0), (1, 0, 0), (0, 1, 0), number) for i, number in enumerate([*SIZES, 0])]
    objects = [thing(number, name, round(10 * size)) for number, (name, size) in SIZES.items()]
    return PanopticMap(tuple(objects), joined(*plates))


def color_of(colors, panoptic, number):
    (color,) = np.unique(colors.values[panoptic.mesh.instances == number].round(), axis=0)
    return color.tolist()


def test_by_instance_the_largest_things_have_the_first_hues_and_stuff_is_pale(panoptic):
    colors = style_colors(panoptic, "instance")
    assert not colors.blends
    assert [color_of(colors, panoptic, number) for number in (3, 5, 2, 4)] == HUES[:4].tolist()
    assert [color_of(colors, panoptic, number) for number in (1, 6)] == STUFF[:2].tolist()
    assert color_of(colors, panoptic, 0) == list(NOBODY)


def test_by_class_what_has_one_name_has_one_colour_and_the_nameless_none(panoptic):
    colors = style_colors(panoptic, "class")
    assert color_of(colors, panoptic, 2) == color_of(colors, panoptic, 4)
    assert color_of(colors, panoptic, 2) != color_of(colors, panoptic, 3)
    assert color_of(colors, panoptic, 5) == list(NOBODY)


def test_own_colours_are_the_mesh_s(panoptic):
    colors = style_colors(panoptic, "color")
    assert colors.blends
    np.testing.assert_array_equal(colors.values, panoptic.mesh.colors)


def test_texture_stays_visible_under_a_flat_colour(panoptic):
    panoptic.mesh.colors[panoptic.mesh.instances == 3] = [[90] * 3, [110] * 3, [90] * 3, [110] * 3]
    values = style_colors(panoptic, "instance").values[panoptic.mesh.instances == 3]
    assert (values[1] > values[0]).all()
    np.testing.assert_allclose(values.mean(axis=0), HUES[0], rtol=0.01)


def test_hits_are_in_colour_and_the_rest_is_grey(panoptic):
    hits = [Hit(panoptic.objects[1], 0.9, "chair"), Hit(panoptic.objects[3], 0.3, "chair")]
    scene = answer_scene(panoptic, hits)
    assert scene.names == {2: "1 chair 0.90", 4: "2 chair 0.30"}
    assert list(scene.wanted) == [2, 4]
    best, second = (np.ptp(color_of(scene.colors, panoptic, number)) for number in (2, 4))
    assert color_of(scene.colors, panoptic, 2) == list(HIT)
    assert best > 1.3 * second > 60
    assert all(np.ptp(color_of(scene.colors, panoptic, number)) < 10 for number in (0, 1, 3, 5))


def test_names_are_of_each_kind_of_thing_then_of_all_then_of_one_surface_of_a_kind(panoptic):
    scene = map_scene(panoptic, "instance")
    assert list(scene.names.items()) == [
        (3, "table"), (2, "chair"), (7, "lamp"), (4, "chair"), (1, "floor"), (6, "ceiling"),
    ]  # fmt: skip
    assert set(scene.wanted) == {2, 3, 4, 7}
    np.testing.assert_array_equal(scene.left_out, panoptic.mesh.instances == 6)


def test_without_named_things_the_angle_goes_by_all_of_them(panoptic):
    objects = tuple(thing(o.id, None, o.n_vertices) for o in panoptic.objects)
    scene = map_scene(PanopticMap(objects, panoptic.mesh), "instance")
    assert not scene.names
    assert set(scene.wanted) == set(SIZES)
    assert scene.left_out is None
