"""The synthetic room as a recording: its pictures, its camera, and the chair that moves."""

from __future__ import annotations

import numpy as np
import pytest

from data_tools.synthetic.rendering.ray_renderer import scene_of
from data_tools.synthetic.scenes.living_room import HEIGHT_M, LENGTH_M, WIDTH_M, living_room
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.synthetic.truth.true_surface import ground_truth
from data_tools.synthetic.truth.visibility import CameraView, Viewpoint
from razer.errors import BadInput
from razer.geometry import inverse, project, transform_points
from tests.support.frames import world_points
from tests.support.solids import after_move


@pytest.fixture(scope="module")
def room() -> SyntheticRoom:
    return SyntheticRoom(0, n_frames=40, width=160, height=120)


def test_depth_lies_on_the_planes_of_floor_ceiling_and_walls(room: SyntheticRoom) -> None:
    planes = {1: (2, 0.0), 2: (2, HEIGHT_M), 3: (1, -WIDTH_M / 2), 4: (0, LENGTH_M / 2), 5: (1, WIDTH_M / 2)}
    planes[6] = (0, -LENGTH_M / 2)
    checked = set()
    for index in range(0, 40, 3):
        frame = room[index]
        assert frame.instance_ids is not None
        points = world_points(frame)
        for number, (axis, value) in planes.items():
            on = frame.instance_ids == number
            checked |= {number} if on.any() else set()
            assert np.abs(points[on][:, axis] - value).max(initial=0) < 1e-4
    assert checked == set(planes)


def test_a_texture_stays_on_its_surface(room: SyntheticRoom) -> None:
    """The colour of a wall point is the same from two places, up to blur and filtering."""
    rows = []
    for index in range(0, 40, 2):
        here, there = room[index], room[(index + 1) % 40]
        points = world_points(here)
        u, v, z = project(transform_points(inverse(there.pose), points), here.intrinsics.matrix)
        x, y = np.rint(np.nan_to_num(u, nan=-1)).astype(int), np.rint(np.nan_to_num(v, nan=-1)).astype(int)
        inside = (x >= 0) & (x < 160) & (y >= 0) & (y < 120) & (z > 0)
        x, y = x.clip(0, 159), y.clip(0, 119)
        agree = inside & (np.abs(there.depth[y, x] - z) < 0.01) & (there.instance_ids[y, x] == here.instance_ids)
        grey = here.rgb.mean(axis=2)[agree], there.rgb.mean(axis=2)[y, x][agree]
        rows.append(np.stack(grey))
    first, second = np.concatenate(rows, axis=1)
    assert len(first) > 50_000
    assert np.corrcoef(first, second)[0, 1] > 0.9


def test_frames_are_a_pure_function_of_the_arguments(room: SyntheticRoom) -> None:
    again = SyntheticRoom(0, n_frames=40, width=160, height=120)
    late, early = again[31], again[2]
    for one, other in ((room[2], early), (room[31], late)):
        assert np.array_equal(one.rgb, other.rgb)
        assert np.array_equal(one.depth, other.depth)
        assert np.array_equal(one.instance_ids, other.instance_ids)
        assert np.array_equal(one.pose, other.pose)
    assert not np.array_equal(SyntheticRoom(1, n_frames=40, width=160, height=120)[2].rgb, early.rgb)


def test_the_camera_is_upright_inside_the_room_and_moves_smoothly() -> None:
    room = SyntheticRoom(2, width=16, height=12)
    poses = np.stack([room[index].pose for index in range(240)])
    assert (poses[:, 2, 1] < -0.75).all()
    assert (np.abs(poses[:, :3, 3]) < (LENGTH_M / 2, WIDTH_M / 2, HEIGHT_M)).all()
    assert np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1).max() < 0.15
    turn = np.einsum("nij,nij->n", poses[1:, :3, :3], poses[:-1, :3, :3])
    assert np.degrees(np.arccos((turn - 1) / 2)).max() < 7
    # It comes back to where it started.
    assert np.linalg.norm(poses[-1, :3, 3] - poses[0, :3, 3]) < 0.3


def test_length_and_index_are_checked(room: SyntheticRoom) -> None:
    assert len(room) == 40
    for index in (-1, 40):
        with pytest.raises(IndexError):
            room[index]
    with pytest.raises(BadInput, match="at least 1"):
        SyntheticRoom(n_frames=0)


def test_noise_repeats_and_loses_readings_at_edges_only(room: SyntheticRoom) -> None:
    noisy = SyntheticRoom(0, n_frames=40, width=160, height=120, noise=True)
    assert np.array_equal(noisy[5].depth, noisy[5].depth)
    lost = noisy[5].depth == 0
    assert 0 < lost.mean() < 0.4
    clean = room[5].depth
    y, x = np.nonzero(lost)
    for row, column in zip(y, x, strict=True):
        patch = clean[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
        assert np.ptp(patch) > 0.05


def test_a_moved_chair_stands_elsewhere_from_the_middle_on() -> None:
    room = SyntheticRoom(0, n_frames=40, width=160, height=120, moved=True)
    assert room.move is not None
    assert room.move.frame == 20
    layout = living_room(0)
    number = room.move.instance
    assert layout.things[number].class_name == "chair"
    centers = {}
    for when in (range(20), range(20, 40)):
        points = [world_points(frame)[frame.instance_ids == number] for frame in map(room.__getitem__, when)]
        centers[when.start] = np.concatenate(points).mean(axis=0)
    assert 0.7 < np.linalg.norm(centers[20] - centers[0]) < 1.4
    truth = room.truth(spacing_m=0.05)
    chair = truth.vertices[truth.instances == number]
    assert np.linalg.norm(chair.mean(axis=0)[:2] - centers[20][:2]) < 0.25
    # Only views from after the move count for the chair.
    late = [Viewpoint(room[i].pose, scene_of(after_move(layout))) for i in range(20, 40)]
    view = CameraView(room.intrinsics, (0.1, 5.0))
    expected = ground_truth(after_move(layout), late, view, 0.05).visible
    own = truth.instances == number
    assert np.array_equal(truth.visible[own], expected[own])
