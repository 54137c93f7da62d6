"""Won shares and the frozen result."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from razer.config import BankSettings
from razer.mesh.labelled_mesh import LabelledMesh
from razer.panoptic_map import PanopticMap
from razer.tracking.track import Track
from razer.volume.surface_cache import SurfaceVoxels
from razer.volume.voxel_map import VoxelMap
from razer.volume.won_shares import won_shares as shares_on
from tests.support.scenes import COARSE, axis_box, cells_at, detection, unit


def won_shares(voxels: VoxelMap) -> dict[int, float]:
    return shares_on(voxels, SurfaceVoxels.at(voxels, voxels.surface_addresses()))


def strip() -> VoxelMap:
    """Ten voxels: 1 claims all, 2 wins six of them, 3 has a vote in one and wins none."""
    voxels = VoxelMap(COARSE)
    voxels.admit(3)
    voxels.allocate(np.zeros((1, 3), np.int32))
    voxels.pages.views("weight")[0].fill_(9.0)  # all of it surface: weights are high, distances are zero
    for claims in (range(10), range(10)):
        voxels.vote(cells_at([[x, 0, 0] for x in claims]), np.full(10, 1, np.int32))
    for _ in range(3):
        voxels.vote(cells_at([[x, 0, 0] for x in range(6)]), np.full(6, 2, np.int32))
    voxels.vote(cells_at([[9, 0, 0]]), np.full(1, 3, np.int32))
    return voxels


def test_the_share_of_votes_in_voxels_that_were_won() -> None:
    assert won_shares(strip()) == pytest.approx({1: 0.4, 2: 1.0, 3: 0.0})


def test_one_mask_that_joined_a_thing_with_its_wall_costs_a_small_share() -> None:
    voxels = VoxelMap(COARSE)
    voxels.admit(2)
    voxels.allocate(np.zeros((1, 3), np.int32))
    voxels.pages.views("weight")[0].fill_(9.0)
    wall = cells_at([[x, y, 0] for x in range(8) for y in range(8)])
    for _ in range(5):
        voxels.vote(wall, np.full(64, 1, np.int32))
    cup = cells_at([[x, 0, 4] for x in range(4)])
    for _ in range(20):
        voxels.vote(cup, np.full(4, 2, np.int32))
    voxels.vote(wall, np.full(64, 2, np.int32))
    assert won_shares(voxels)[2] == pytest.approx(80 / 144)


def test_a_single_vote_that_won_is_all_and_an_id_without_any_has_no_share() -> None:
    voxels = VoxelMap(COARSE)
    voxels.admit(3)
    voxels.allocate(np.zeros((1, 3), np.int32))
    (weight,) = voxels.pages.views("weight")
    weight[:] = 9.0
    voxels.vote(cells_at([[5, 5, 5]]), np.array([2], np.int32))
    assert won_shares(voxels) == {2: 1.0}


def test_shares_follow_fusions_and_prunings() -> None:
    voxels = strip()
    voxels.replace(2, 0)
    voxels.settle()
    assert won_shares(voxels) == pytest.approx({1: 1.0, 3: 0.0})
    voxels.replace(3, 1)
    voxels.settle()
    assert won_shares(voxels) == pytest.approx({1: 1.0})


def test_nobody_has_a_share_in_an_unclaimed_map() -> None:
    voxels = VoxelMap(COARSE)
    assert won_shares(voxels) == {}
    voxels.admit(2)
    voxels.allocate(np.zeros((1, 3), np.int32))
    assert won_shares(voxels) == {}


def test_the_frozen_map_says_what_the_tracks_know() -> None:
    box = axis_box((0, 0, 0), (1, 1, 1))
    tracks = [
        Track(5, detection(box, unit(0, 1), class_name="cup"), 3, BankSettings()),
        Track(2, detection(box, unit(1, 0)), 7, BankSettings()),
    ]
    instances = np.array([5, 5, 2, 9, 0, 5], np.int32)  # 9 was pruned
    mesh = LabelledMesh(np.zeros((6, 3), np.float32), np.zeros((6, 3), np.uint8), instances, np.zeros((0, 3), np.int32))
    frozen = PanopticMap.of(tracks, mesh)
    assert [o.id for o in frozen.objects] == [2, 5]
    assert [o.n_vertices for o in frozen.objects] == [1, 3]
    assert [o.class_name for o in frozen.objects] == [None, "cup"]
    assert [(o.first_frame, o.last_frame, o.observations) for o in frozen.objects] == [(7, 7, 1), (3, 3, 1)]
    assert frozen.mesh.instances.tolist() == [5, 5, 2, 0, 0, 5]
    assert mesh.instances.tolist() == [5, 5, 2, 9, 0, 5]
    for found in frozen.objects:
        assert_allclose(np.linalg.norm(found.embeddings, axis=1), 1)
        assert found.weights.sum() == pytest.approx(1)


def test_an_object_without_vertices_and_a_map_without_objects() -> None:
    empty = LabelledMesh(
        np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint8), np.zeros(0, np.int32), np.zeros((0, 3), np.int32)
    )
    lone = PanopticMap.of([Track(3, detection(axis_box((0, 0, 0), (1, 1, 1))), 0, BankSettings())], empty)
    assert [o.n_vertices for o in lone.objects] == [0]
    assert PanopticMap.of([], empty).objects == ()
