"""Things carried away leave no ghost, and things that stay are not eaten."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose
from scenes import COARSE, axis_box, box_depth, frame_of, look, plane_depth, pose

from razer.carving import carve, nearest_readings
from razer.frame import Frame
from razer.surface import extract_mesh, extract_points
from razer.voxels import VoxelMap
from razer.votes import winner

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


@pytest.fixture
def furnished() -> VoxelMap:
    """A wall with a box before it, seen ten times."""
    voxels = VoxelMap(COARSE)
    voxels.admit(THING)
    for i, at in enumerate(AT):
        fuse(voxels, frame_of(scene_depth(at), at, index=i))
    return voxels


def labels_of_attribute(voxels: VoxelMap) -> torch.Tensor:
    rows = voxels.active_rows()[1]
    return voxels.attribute("label").unflatten(0, (-1, 16**3))[rows]


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
    assert not (labels_of_attribute(furnished) == THING).any()
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


def everything(voxels: VoxelMap) -> list[torch.Tensor]:
    return [voxels.attribute(n).clone() for n in ("tsdf", "weight", "color", "label", "ids", "counts")]


def test_a_thing_that_stays_is_untouched(furnished: VoxelMap) -> None:
    before = everything(furnished)
    for at in [*AT, pose((0.3, -0.2, 0.1), (5, -8, 3))]:
        carve(furnished, look(frame_of(scene_depth(at), at)))
    assert all(torch.equal(a, b) for a, b in zip(before, everything(furnished), strict=True))


def test_missing_depth_carves_nothing(furnished: VoxelMap) -> None:
    before = everything(furnished)
    depth = np.zeros((120, 160))
    depth[0, 0] = WALL_M
    depth[::4, ::4] = WALL_M  # readings too lonely to be trusted
    carve(furnished, look(frame_of(depth)))
    assert all(torch.equal(a, b) for a, b in zip(before, everything(furnished), strict=True))


def test_what_is_hidden_or_out_of_view_is_not_carved(furnished: VoxelMap) -> None:
    before = everything(furnished)
    carve(furnished, look(frame_of(np.full((120, 160), 0.5))))  # a hand before the camera
    away = pose((0, 0, 0), (0, 180, 0))
    carve(furnished, look(frame_of(np.full((120, 160), 4.0), away)))
    assert all(torch.equal(a, b) for a, b in zip(before, everything(furnished), strict=True))


def test_one_contradiction_halves_and_does_not_erase(furnished: VoxelMap) -> None:
    weights, counts = furnished.attribute("weight").clone(), furnished.attribute("counts").clone()
    carve(furnished, look(frame_of(wall_depth(AT[0]), AT[0])))
    touched = furnished.attribute("weight") != weights
    assert touched.any()
    lasting = touched & (weights >= 2)
    assert torch.equal(furnished.attribute("weight")[lasting], weights[lasting] / 2)
    rows = lasting[:, 0]
    assert torch.equal(furnished.attribute("counts")[rows], counts[rows] // 2)


def test_label_stays_the_winner_of_the_votes(furnished: VoxelMap) -> None:
    """Voxels with one vote lose it at the first contradiction, and must not keep a label nobody votes for."""
    surface = look(frame_of(wall_depth(AT[0]), AT[0]))
    for _ in range(4):
        carve(furnished, surface)
        ids, counts = furnished.attribute("ids"), furnished.attribute("counts")
        expected = winner(ids.T.contiguous(), counts.T.contiguous())
        assert torch.equal(furnished.attribute("label")[:, 0], expected)


def test_nearest_readings_by_a_literal_loop() -> None:
    depth = np.random.default_rng(0).uniform(1, 3, (12, 15)).astype(np.float32)
    depth[5, 7] = 0
    nearest = nearest_readings(depth)
    for row in range(12):
        for column in range(15):
            around = depth[max(row - 2, 0) : row + 3, max(column - 2, 0) : column + 3]
            assert nearest[row, column] == around.min()
