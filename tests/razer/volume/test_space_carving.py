"""Things carried away leave no ghost, and things that stay are not eaten."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import razer.volume.blocks.block_pages
from razer.frame import Frame
from razer.storage.volume_npz import load_voxels, save_voxels
from razer.volume.mesh_extraction import extract_mesh, extract_points
from razer.volume.space_carving import KEPT_SHARE, _in_view, _rows_in_view, carve, nearest_readings
from razer.volume.voxel_map import VoxelMap
from tests.support.scenes import COARSE, axis_box, box_depth, contents, frame_of, look, plane_depth, pose, same_contents

WALL, THING = 1, 2
WALL_M = 2.0
BOX = axis_box((0.1, 0.0, 1.3), (0.4, 0.4, 0.3))
AT = [pose((0.02 * i - 0.1, 0.01 * i, 0), (0, 0.5 * i, 0)) for i in range(10)]


def wall_depth(at: np.ndarray) -> np.ndarray:
    return plane_depth(at, (0, 0, 1), WALL_M)


def scene_depth(at: np.ndarray) -> np.ndarray:
    return np.minimum(wall_depth(at), box_depth(at, BOX))


def fuse(voxels: VoxelMap, frame: Frame) -> None:
    """Integrate, and vote for the thing that each cell of the frame belongs to."""
    voxels.integrate(frame)
    cells = look(frame).cells
    voxels.vote(cells, np.where(cells.points[:, 2] < WALL_M - 0.2, THING, WALL).astype(np.int32))


@pytest.fixture(autouse=True)
def few_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Room for what these maps need: whole attributes are quicker to compare."""
    monkeypatch.setattr(razer.volume.blocks.block_pages, "PAGE_BLOCKS", 64)


@pytest.fixture
def furnished() -> VoxelMap:
    """A wall with a box before it, seen ten times."""
    voxels = VoxelMap(COARSE)
    voxels.admit(THING)
    for i, at in enumerate(AT):
        fuse(voxels, frame_of(scene_depth(at), at, index=i))
    return voxels


def in_front(points: np.ndarray) -> np.ndarray:
    return points[:, 2] < WALL_M - 0.2


def test_the_box_is_mapped_to_begin_with(furnished: VoxelMap) -> None:
    points = extract_points(furnished)
    assert np.count_nonzero(points.instances == THING) > 80
    assert np.count_nonzero(in_front(extract_mesh(furnished).vertices)) > 80


def test_a_thing_carried_away_leaves_no_ghost(furnished: VoxelMap) -> None:
    for i, at in enumerate(AT):
        frame = frame_of(wall_depth(at), at, index=10 + i)
        fuse(furnished, frame)
        carve(furnished, look(frame))
    points = extract_points(furnished)
    assert not in_front(points.positions).any()
    assert not (points.instances == THING).any()
    assert not (contents(furnished)["label"] == THING).any()
    mesh = extract_mesh(furnished)
    assert not in_front(mesh.vertices).any()
    assert_allclose(mesh.vertices[:, 2], WALL_M, atol=COARSE.voxel_size_m / 2)


def test_the_wall_behind_is_whole_again(furnished: VoxelMap) -> None:
    for i, at in enumerate(AT):
        frame = frame_of(wall_depth(at), at, index=10 + i)
        fuse(furnished, frame)
        carve(furnished, look(frame))
    vertices = extract_mesh(furnished).vertices
    x, y = np.meshgrid(np.arange(-0.4, 0.5, 0.05), np.arange(-0.4, 0.4, 0.05))
    probes = np.stack([x, y, np.full(x.shape, WALL_M)], axis=-1).reshape(-1, 3)
    assert np.linalg.norm(probes[:, None] - vertices[None], axis=2).min(axis=1).max() < COARSE.voxel_size_m


def test_a_thing_that_stays_is_untouched(furnished: VoxelMap) -> None:
    """Only the outer voxels of the truncation band may change: before the surface, they are free space indeed."""
    before, points, mesh = contents(furnished), extract_points(furnished), extract_mesh(furnished)
    for at in [*AT, pose((0.3, -0.2, 0.1), (5, -8, 3))]:
        carve(furnished, look(frame_of(scene_depth(at), at)))
    after = contents(furnished)
    inner = (np.abs(before["tsdf"]) < 0.5)[..., 0]
    assert all(np.array_equal(before[name][inner], after[name][inner]) for name in before if name != "keys")
    assert all(np.array_equal(a, vars(extract_points(furnished))[name]) for name, a in vars(points).items())
    # The mesh may only lose the skirts that truncation leaves around a silhouette.
    kept = extract_mesh(furnished).vertices
    assert {*map(tuple, kept)} <= {*map(tuple, mesh.vertices)}
    assert len(kept) > 0.98 * len(mesh.vertices)


def test_missing_depth_carves_nothing(furnished: VoxelMap) -> None:
    before = contents(furnished)
    depth = np.zeros((120, 160))
    depth[::4, ::4] = WALL_M  # readings too lonely to be trusted
    carve(furnished, look(frame_of(depth)))
    assert same_contents(before, contents(furnished))


def test_what_is_hidden_or_out_of_view_is_not_carved(furnished: VoxelMap) -> None:
    before = contents(furnished)
    carve(furnished, look(frame_of(np.full((120, 160), 0.5))))  # a hand before the camera
    carve(furnished, look(frame_of(np.full((120, 160), 4.0), pose(turn_deg=(0, 180, 0)))))
    assert same_contents(before, contents(furnished))


def test_one_contradiction_weakens_and_does_not_erase(furnished: VoxelMap) -> None:
    before = contents(furnished)
    carve(furnished, look(frame_of(wall_depth(AT[0]), AT[0])))
    after = contents(furnished)
    lasting = ((after["weight"] != before["weight"]) & (before["weight"] >= 1 / KEPT_SHARE))[..., 0]
    assert np.count_nonzero(before["label"][lasting] == THING) > 50
    assert np.array_equal(after["weight"][lasting], before["weight"][lasting] * KEPT_SHARE)
    assert np.array_equal(after["counts"][lasting], before["counts"][lasting] // int(1 / KEPT_SHARE))
    assert np.array_equal(after["tsdf"][lasting], before["tsdf"][lasting])


@pytest.fixture
def contradicted() -> VoxelMap:
    """The box seen eleven times and voted for only once, then once seen through."""
    voxels = VoxelMap(COARSE)
    voxels.admit(THING)
    for at in AT:
        voxels.integrate(frame_of(scene_depth(at), at))
    fuse(voxels, frame_of(scene_depth(AT[0]), AT[0]))
    assert np.count_nonzero(contents(voxels)["label"] == THING) > 50
    carve(voxels, look(frame_of(wall_depth(AT[0]), AT[0])))
    return voxels


def test_a_voxel_whose_last_vote_is_carved_keeps_no_label(contradicted: VoxelMap) -> None:
    held = contents(contradicted)
    unclaimed = ~(held["counts"] > 0).any(axis=2)
    assert not held["label"][unclaimed].any()


def test_a_pruned_thing_does_not_come_back_from_the_file(contradicted: VoxelMap, tmp_path: Path) -> None:
    contradicted.replace(THING, 0)
    save_voxels(tmp_path / "map.npz", contradicted)
    loaded = load_voxels(tmp_path / "map.npz")
    assert not (extract_points(contradicted).instances == THING).any()
    assert not (extract_points(loaded).instances == THING).any()


def test_nearest_readings_by_a_literal_loop() -> None:
    depth = np.random.default_rng(0).uniform(1, 3, (12, 15)).astype(np.float32)
    depth[5, 7] = 0
    nearest = nearest_readings(depth)
    for row in range(12):
        for column in range(15):
            around = depth[max(row - 2, 0) : row + 3, max(column - 2, 0) : column + 3]
            assert nearest[row, column] == around.min()


@pytest.mark.parametrize("seed", range(6))
def test_blocks_in_view_are_those_that_a_look_at_all_blocks_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    voxels = VoxelMap(COARSE)
    voxels.allocate(np.unique(rng.integers(-12, 12, (60, 3)), axis=0).astype(np.int32))
    keys, rows = voxels.pages.all()
    n_in_view = []
    for _ in range(20):
        at = pose(rng.uniform(-4, 4, 3), rng.uniform(-180, 180, 3))
        surface = look(frame_of(np.full((120, 160), rng.uniform(0.5, 5.0)), at))
        expected = rows[np.flatnonzero(_in_view(keys, voxels, surface)).tolist()]
        assert _rows_in_view(voxels, surface).tolist() == expected.tolist()
        n_in_view.append(len(expected))
    assert 0 < sum(n_in_view) < 20 * len(keys) / 2
