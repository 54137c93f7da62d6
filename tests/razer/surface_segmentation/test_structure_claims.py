"""Planes of structure go to the stuff that has most of them; what lies flat in them stays what it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from razer.boxes.oriented_box import OrientedBox
from razer.config import SurfaceSegmentationSettings
from razer.map_object import MapObject
from razer.panoptic_map import PanopticMap
from razer.surface_segmentation.structure_claims import with_claimed_structure
from tests.support.voxel_surfaces import voxel_surface

SETTINGS = SurfaceSegmentationSettings()
FLOOR, CUPBOARD = 1, 2
FLOOR_ID, CUPBOARD_ID, RUG_ID, SLIVER_ID, SPECK_ID = 3, 5, 7, 9, 11
NAMES = {FLOOR_ID: "floor", CUPBOARD_ID: "cabinet", RUG_ID: "rug", SLIVER_ID: "floor", SPECK_ID: "wall"}
STUFF = {FLOOR_ID, SLIVER_ID, SPECK_ID}


def kitchen(spill: float, *, floor: str = "floor") -> PanopticMap:
    """A cupboard on a floor of 2.4 by 2.4 metres; its masks spill that share of the way over the floor. A rug lies on
    it, a piece of it is a floor of its own, and a speck of it is called wall."""
    solids = np.zeros((120, 120, 50), np.uint8)
    solids[:, :, 0] = FLOOR
    solids[1:30, 1:119, 1:45] = CUPBOARD
    mesh = voxel_surface(solids, {FLOOR: (150, 120, 90), CUPBOARD: (140, 20, 30)})
    x, y, z = mesh.vertices.T
    on_floor = (mesh.instances == FLOOR) & (z < 0.03)
    labels = np.where(mesh.instances == CUPBOARD, CUPBOARD_ID, FLOOR_ID).astype(np.int32)
    labels[on_floor & (x < 0.6 + spill * 1.8)] = CUPBOARD_ID
    labels[on_floor & (x > 1.9) & (y < 0.6)] = RUG_ID
    labels[on_floor & (x > 2.2) & (y > 2.2)] = SLIVER_ID
    labels[on_floor & (x > 1.8) & (x < 1.9) & (y > 1.5) & (y < 1.6)] = SPECK_ID
    names = NAMES | {FLOOR_ID: floor}
    objects = tuple(instance(i, name, int((labels == i).sum())) for i, name in names.items())
    return PanopticMap(objects, replace(mesh, instances=labels), up=np.array([0.0, 0.0, 1.0]))


def instance(number: int, name: str, n_vertices: int) -> MapObject:
    box = OrientedBox(np.zeros(3), np.eye(3), np.ones(3))
    sizes = (n_vertices, n_vertices)
    empty = np.zeros((0, 0), np.float32)
    is_stuff = number in STUFF
    return MapObject(number, name, 0.5, box, *sizes, 4, 0, 9, empty, np.zeros(0), is_stuff=is_stuff)


def claimed(panoptic: PanopticMap) -> PanopticMap:
    return with_claimed_structure(panoptic, SETTINGS, voxel_size_m=0.02)


def test_a_floor_takes_back_what_a_cupboard_s_masks_spilled_on_it() -> None:
    before = kitchen(spill=0.4)
    after = claimed(before)
    x, y, z = before.mesh.vertices.T
    spilled = (before.mesh.instances == CUPBOARD_ID) & (z < 0.03) & (x > 0.7) & (y < 2.36)  # the border has specks
    assert spilled.sum() > 1000
    assert (after.mesh.instances[spilled] == FLOOR_ID).all()
    high = (before.mesh.instances == CUPBOARD_ID) & (z > 0.1)
    assert (after.mesh.instances[high] == CUPBOARD_ID).all(), "its own surface stays the cupboard's"


def test_what_lies_flat_in_the_plane_keeps_its_name_unless_it_is_the_same() -> None:
    before = kitchen(spill=0.0)
    after = claimed(before).mesh.instances
    labels = before.mesh.instances
    assert (after[labels == RUG_ID] == RUG_ID).all()
    assert (after[labels == SPECK_ID] == SPECK_ID).all(), "another class, all of it in the plane"
    assert (after[labels == SLIVER_ID] == FLOOR_ID).all(), "a piece of floor in the floor's plane"


def test_instances_say_what_they_have_now_and_those_without_surface_are_gone() -> None:
    after = claimed(kitchen(spill=0.4))
    labels = after.mesh.instances
    assert {item.id for item in after.objects} == set(np.unique(labels[labels > 0]).tolist())
    for item in after.objects:
        assert item.n_vertices == (labels == item.id).sum()
    [cupboard] = [item for item in after.objects if item.id == CUPBOARD_ID]
    points = after.mesh.vertices[labels == CUPBOARD_ID]
    assert cupboard.box.contains(points, margin_m=0.02).mean() > 0.95
    assert sorted(cupboard.box.extent)[1] < 1.2, "the box has shrunk with it"


@pytest.mark.parametrize("share_left", [0.25])
def test_where_stuff_has_too_little_of_the_plane_nothing_changes(share_left: float) -> None:
    before = kitchen(spill=1 - share_left)
    np.testing.assert_array_equal(claimed(before).mesh.instances, before.mesh.instances)


def test_without_stuff_nothing_changes() -> None:
    before = kitchen(spill=0.4)
    things = tuple(replace(item, is_stuff=False) for item in before.objects)
    np.testing.assert_array_equal(claimed(replace(before, objects=things)).mesh.instances, before.mesh.instances)


def test_what_the_floor_took_back_is_part_of_nothing() -> None:
    """One part has the cupboard and the edge of its spill, one the rest of the spill alone."""
    before = kitchen(spill=0.4)
    x, y, z = before.mesh.vertices.T
    of_cupboard = before.mesh.instances == CUPBOARD_ID
    spilled = of_cupboard & (z < 0.03) & (x > 1.0) & (y < 2.36)  # the border has specks
    labels = np.select([spilled, of_cupboard], [21, 20], 0).astype(np.int32)
    sizes = np.bincount(labels)
    parts = tuple(replace(instance(i, "door", int(sizes[i])), part_of=CUPBOARD_ID) for i in (20, 21))
    after = claimed(replace(before, parts=parts, vertex_parts=labels))
    assert after.vertex_parts is not None
    wholes = {part.id: part.part_of for part in after.parts}
    assert wholes == {20: CUPBOARD_ID}
    assert after.parts[0].n_vertices < sizes[20]
    for part in after.parts:
        own = after.vertex_parts == part.id
        assert part.n_vertices == own.sum()
        assert (after.mesh.instances[own] == part.part_of).all()
