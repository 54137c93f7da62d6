"""A map whose instances are segments of its surface: what it keeps of the masks' instances, and whole runs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import razer
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.boxes.oriented_box import OrientedBox
from razer.config import SurfaceSegmentationSettings
from razer.detection.best_views import BestView, Region
from razer.map_object import MapObject
from razer.models import make_segmenter, prefers_fused_surface
from razer.panoptic_map import PanopticMap
from razer.surface_segmentation.segmented_map import segmented_map
from tests.support.voxel_surfaces import voxel_surface

FLOOR, BOX = 1, 2
SETTINGS = SurfaceSegmentationSettings()


def instance(number: int, n_vertices: int, axis: int, frames: tuple[int, int]) -> MapObject:
    view = BestView(frames[0], Region((0, 0, 9, 9), 81, True))
    return MapObject(
        number,
        None,
        0.5,
        OrientedBox(np.zeros(3), np.eye(3), np.ones(3)),
        n_vertices,
        n_vertices,
        4 + axis,
        *frames,
        np.eye(3, dtype=np.float32)[[axis]],
        np.ones(1),
        (view,),
    )


@pytest.fixture(scope="module")
def box_on_floor() -> PanopticMap:
    """A box in two instances, 5 (the lower two thirds) and 7, on a floor in instance 3 and some of it in 9."""
    solids = np.zeros((60, 60, 40), np.uint8)
    solids[:, :, 0] = FLOOR
    solids[20:40, 20:32, 1:31] = BOX
    mesh = voxel_surface(solids, {FLOOR: (150, 120, 90), BOX: (60, 60, 160)})
    low, left = mesh.vertices[:, 2] < 0.42, mesh.vertices[:, 0] < 0.2
    labels = np.where(mesh.instances == BOX, np.where(low, 5, 7), np.where(left, 9, 3)).astype(np.int32)
    sizes = np.bincount(labels)
    objects = [instance(i, int(sizes[i]), k % 3, (10 * k, 90 - k)) for k, i in enumerate((3, 5, 7, 9))]
    return PanopticMap(tuple(objects), replace(mesh, instances=labels), up=np.array([0.0, 0.0, 1.0]))


def test_fragments_become_one_instance_that_knows_what_they_knew(box_on_floor):
    segmented = segmented_map(box_on_floor, SETTINGS, voxel_size_m=0.02, newest_id=20)
    things = [item for item in segmented.objects if not item.is_stuff]
    assert [item.id for item in things] == [5], "the id of the fragment that is most of it"
    [box] = things
    assert (box.first_frame, box.last_frame, box.observations) == (10, 89, 6)
    np.testing.assert_array_equal(box.embeddings, np.eye(3)[[1, 2]])  # of 5, then of 7, by their surface
    np.testing.assert_allclose(box.weights, [0.62, 0.38], atol=0.06)
    assert [view.frame for view in box.views] == [10]  # that of frame 20 shows the same
    np.testing.assert_allclose(np.sort(box.box.extent), [0.24, 0.4, 0.6], atol=0.03)
    assert box.n_vertices == (segmented.mesh.instances == 5).sum()


def test_structure_is_stuff_with_a_name(box_on_floor):
    [floor] = [o for o in segmented_map(box_on_floor, SETTINGS, voxel_size_m=0.02).objects if o.is_stuff]
    assert (floor.class_name, floor.id) == ("floor", 3)
    assert floor.n_voxels == pytest.approx(60 * 60 - 20 * 12, rel=0.05)


def test_new_instances_have_ids_that_no_instance_ever_had(box_on_floor):
    without = replace(
        box_on_floor, objects=(), mesh=replace(box_on_floor.mesh, instances=box_on_floor.mesh.instances * 0)
    )
    segmented = segmented_map(without, SETTINGS, voxel_size_m=0.02, newest_id=20)
    assert sorted(item.id for item in segmented.objects) == [21, 22]
    assert {*np.unique(segmented.mesh.instances)} <= {0, 21, 22}
    assert all(len(item.embeddings) == 0 and item.observations == 0 for item in segmented.objects)


@pytest.fixture(scope="module")
def mapped() -> razer.Mapper:
    config = razer.MapperConfig.model_validate({"voxels": {"voxel_size_m": 0.04}})
    mapper = razer.Mapper(config, "geometric", "appearance")
    room = SyntheticRoom(0, 60, 160, 120)
    for index in range(0, len(room), 12):
        mapper.step(room[index])
    return mapper


def test_a_finished_run_has_named_structure_and_is_saved_as_it_is(mapped, tmp_path):
    finished = mapped.finish()
    stuff = {item.class_name for item in finished.objects if item.is_stuff}
    assert {"wall", "floor"} <= stuff <= {"wall", "floor", "ceiling"}
    assert {*np.unique(finished.mesh.instances)} - {0} == {item.id for item in finished.objects}
    finished.save(tmp_path / "map")
    opened = razer.load_map(tmp_path / "map")
    np.testing.assert_array_equal(opened.mesh.instances, finished.mesh.instances)
    assert [(o.id, o.class_name, o.is_stuff) for o in opened.objects] == [
        (o.id, o.class_name, o.is_stuff) for o in finished.objects
    ]


@pytest.mark.parametrize(
    ("use", "segmenter", "is_segmented"),
    [("auto", "geometric", True), ("never", "geometric", False), ("auto", "oracle", False), ("always", "oracle", True)],
)
def test_the_setting_and_the_segmenter_decide(use, segmenter, is_segmented):
    settings = {"surface_segmentation": {"use": use}, "voxels": {"voxel_size_m": 0.08}}
    mapper = razer.Mapper(razer.MapperConfig.model_validate(settings), segmenter, "appearance")
    mapper.step(SyntheticRoom(0, 2, 80, 60)[0])
    finished, by_masks = mapper.finish(), mapper.snapshot()
    assert (finished.mesh.instances != by_masks.mesh.instances).any() == is_segmented


def test_a_combination_is_not_segmented_anew():
    assert prefers_fused_surface(make_segmenter("geometric"))
    assert not prefers_fused_surface(make_segmenter("geometric+oracle"))
