"""The volume after edits: its voxels bear what the mesh bears, and a mesh taken of it anew is the edited one."""

from __future__ import annotations

import numpy as np
import pytest

import razer
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.edits.session import EditSession
from razer.edits.volume_labels import relabelled
from razer.mesh.labelled_mesh import LabelledMesh
from razer.volume.mesh_extraction import extract_mesh, nearest_labels, vertex_labels
from razer.volume.voxel_map import VoxelMap
from tests.support.edited_maps import NOW, by_id, do, plane
from tests.support.scenes import COARSE, cells_at, contents, same_contents


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A small room, mapped with perfect masks and saved; no seams are filled, which no voxel has."""
    voxels = {"voxel_size_m": 0.05, "seam_rings": 0}
    mapper = razer.Mapper(razer.MapperConfig.model_validate({"voxels": voxels}), "oracle", "oracle")
    room = SyntheticRoom(0, 12, 160, 120)
    for index in range(len(room)):
        mapper.step(room[index])
    saved = tmp_path_factory.mktemp("room") / "map"
    mapper.finish().save(saved)
    return saved


@pytest.fixture
def session(folder, tmp_path):
    return EditSession(tmp_path, razer.load_map(folder, edited=False))


def chairs_and_table(panoptic):
    by_size = sorted(panoptic.objects, key=lambda o: -o.n_vertices)
    chairs = [o for o in by_size if o.class_name == "chair"]
    return chairs[0], chairs[1], next(o for o in by_size if o.class_name == "table")


def test_a_mesh_of_the_edited_volume_is_the_edited_mesh(session):
    chair, other, table = chairs_and_table(session.panoptic)
    shelf = next(o for o in session.panoptic.objects if o.class_name == "shelf")
    do(session, "merge", instances=[other.id, chair.id])
    do(session, "split", instance=table.id, region=plane(1, 0, 0, float(table.box.center[0])))
    do(session, "delete", instance=shelf.id)
    edited = session.panoptic
    anew = extract_mesh(edited.volume)
    np.testing.assert_array_equal(anew.vertices, edited.mesh.vertices)
    # At the border of what was deleted, vertices between its voxels and others' are those others' now.
    assert (anew.instances == edited.mesh.instances).mean() > 0.995
    changed = edited.mesh.instances != session._replay.base.mesh.instances
    for is_gone, least in ((False, 0.99), (True, 0.9)):
        rows = changed & ((edited.mesh.instances == 0) == is_gone)
        assert (anew.instances[rows] == edited.mesh.instances[rows]).mean() > least
    assert {chair.id, shelf.id}.isdisjoint(np.unique(anew.instances).tolist())
    assert set(np.unique(anew.instances).tolist()) - {0} <= by_id(edited).keys()


def test_votes_go_where_the_surface_went_and_none_is_lost(session):
    chair, other, _ = chairs_and_table(session.panoptic)
    base = session.panoptic
    before = vertex_labels(base.volume, base.mesh.vertices)
    do(session, "merge", instances=[other.id, chair.id])
    after = vertex_labels(session.panoptic.volume, base.mesh.vertices)
    np.testing.assert_array_equal(after, np.where(before == chair.id, other.id, before))
    nearest = nearest_labels(session.panoptic.volume, base.mesh.vertices)
    assert chair.id not in nearest


def test_what_comes_to_an_instance_does_not_leave_it_with_what_it_had():
    """A voxel with votes for 1 and 2, where 1 became 2 and 2 became 3."""
    voxels, cells = VoxelMap(COARSE), cells_at([[3, 4, 5], [9, 4, 5]])
    voxels.allocate(cells.block_keys)
    for number in (1, 2):
        voxels.admit(number)
    for number in (1, 1, 1, 2, 2):
        voxels.vote(cells, np.full(2, number, np.int32))
    places = np.repeat(cells.points[:1], 2, axis=0).astype(np.float32)
    mesh = LabelledMesh(places, np.zeros((2, 3), np.uint8), np.array([1, 2], np.int32), np.zeros((0, 3), np.int32))
    edited = relabelled(voxels, mesh, np.array([2, 3], np.int32))
    ids, counts = (part.tolist() for part in edited.histograms_at(cells))
    for row in range(2):
        assert {i: n for i, n in zip(ids[row], counts[row], strict=True) if n} == {2: 3, 3: 2}
    assert edited.labels_at(cells).tolist() == [2, 2]


def test_what_was_nobodys_stays_so_and_what_is_deleted_becomes_it():
    voxels, cells = VoxelMap(COARSE), cells_at([[3, 4, 5], [30, 4, 5], [31, 4, 5]])
    voxels.allocate(cells.block_keys)
    for number in (1, 2):
        voxels.admit(number)
    for number in (1, 1, 2):
        voxels.vote(cells, np.array([number, 2, 0], np.int32))
    places = cells.points[:2].astype(np.float32)
    mesh = LabelledMesh(places, np.zeros((2, 3), np.uint8), np.array([1, 2], np.int32), np.zeros((0, 3), np.int32))
    edited = relabelled(voxels, mesh, np.array([0, 2], np.int32), gone=[1])
    # The vote for 2 beneath those for 1 does not make it 2's: the surface there is nobody's now.
    assert edited.labels_at(cells).tolist() == [0, 2, 0]
    assert edited.histograms_at(cells)[1].sum(dim=1).tolist() == [0, 3, 0]


def test_a_rename_leaves_the_volume_and_an_undone_edit_too(session, folder):
    chair, other, _ = chairs_and_table(session.panoptic)
    untouched = contents(razer.load_map(folder, edited=False).volume)
    do(session, "rename", instance=chair.id, name="stool")
    do(session, "merge", instances=[other.id, chair.id])
    session.undo(time=NOW)
    assert same_contents(contents(session.panoptic.volume), untouched)
