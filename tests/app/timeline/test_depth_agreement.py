"""Which of two runs has the better poses: by how their depth images agree, on scenes where the answer is known."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from app.timeline.config import TimelineConfig
from app.timeline.depth_agreement import OTHER_SURFACE_M, pair_offsets_m
from app.timeline.pose_figures import better, pose_figures
from app.timeline.recording.saved_recording import SavedRecording
from app.timeline.rerun_timeline import Timeline
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.frame import Intrinsics
from razer.mesh.labelled_mesh import LabelledMesh
from razer.metrics.scene_pair import TimedPoses
from razer.tracking.step_result import StepResult

CAMERA = Intrinsics(80, 60, 70.0, 70.0, 39.5, 29.5)
WALL_M = 2.0


def wall(depth_m=WALL_M):
    return np.full((60, 80), depth_m, np.float32)


def at(x_m=0.0, z_m=0.0):
    pose = np.eye(4)
    pose[[0, 2], 3] = x_m, z_m
    return pose


def test_images_of_one_wall_agree_where_their_poses_do():
    poses = np.stack([at(), at(0.3, 0.5), at(-0.2)])
    depths = [wall(), wall(WALL_M - 0.5), wall()]
    np.testing.assert_allclose(pair_offsets_m(depths, CAMERA, poses), 0, atol=1e-6)


@pytest.mark.parametrize("off_m", [0.02, 0.1])
def test_the_offset_is_how_far_a_pose_is_off_along_the_view(off_m):
    offsets = pair_offsets_m([wall(), wall()], CAMERA, np.stack([at(), at(0, off_m)]))
    np.testing.assert_allclose(offsets, off_m, atol=1e-6)


def test_what_stands_before_another_surface_is_no_offset_and_little_in_common_does_not_count():
    depth = wall()
    depth[:, :50] = WALL_M - 2 * OTHER_SURFACE_M  # a cupboard, in one image alone
    np.testing.assert_allclose(pair_offsets_m([depth, wall()], CAMERA, np.stack([at(), at()])), 0, atol=1e-6)
    assert np.isnan(pair_offsets_m([wall(), wall()], CAMERA, np.stack([at(), at(50.0)]))).all()
    assert np.isnan(pair_offsets_m([wall(), wall(0)], CAMERA, np.stack([at(), at()]))).all()


def test_the_verdict_needs_a_clear_difference_in_most_pairs():
    even = np.full((2, 20), 0.01)
    assert better(["a", "b"], even).startswith("**No clear difference**")
    clear = even * np.array([[2.0], [1.0]])
    assert better(["a", "b"], clear) == (
        "**b has the better poses**: its depth images agree better (b 1.0 cm, a 2.0 cm)."
    )
    assert better(["a", "b"], clear[::-1]).startswith("**a has")
    few = even.copy()
    few[0, :5] = 0.1  # a few pairs only
    assert better(["a", "b"], few).startswith("**No clear difference**")
    assert "do not tell" in better(["a", "b"], np.zeros((2, 0)))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A room's frames, and the depth images of the timeline of a run over them."""
    room = SyntheticRoom(0, 12, 160, 120)
    path = tmp_path_factory.mktemp("depth") / "timeline.rrd"
    timeline = Timeline(path, room.intrinsics, TimelineConfig(depth_every=1, raster_max_edge=80))
    frames = [room[n] for n in range(len(room))]
    none = np.zeros((0, 3), np.int32)
    mapper = SimpleNamespace(tracks=[], voxels=SimpleNamespace(memory_bytes=0))
    timeline._growing = SimpleNamespace(observe=lambda *_, **__: None, draw=lambda _: None, seen_boxes=lambda _: {})
    for frame in frames:
        timeline.show(frame, StepResult(frame.index, np.zeros((120, 160), np.int32), (), (), (), (), none), mapper, {})
    timeline.close()
    return frames, SavedRecording(path).depth_images()


def test_depth_images_come_back_with_their_times_and_camera(recorded):
    frames, depth = recorded
    np.testing.assert_allclose(depth.stamps, [frame.stamp for frame in frames])
    full = frames[0].intrinsics
    assert (depth.camera.width, depth.camera.height) == (80, 60)
    halved = (full.fx / 2, full.fy / 2, full.cx / 2, full.cy / 2)
    got = (depth.camera.fx, depth.camera.fy, depth.camera.cx, depth.camera.cy)
    np.testing.assert_allclose(got, halved, atol=1e-4)
    np.testing.assert_allclose(depth.images_m[3], frames[3].depth[::2, ::2], atol=0.00051)


def mapped(frames, shift_m):
    """A run whose camera strays by so much from frame to frame, any way."""
    poses = np.array([frame.pose for frame in frames])
    poses[:, :3, 3] += np.random.default_rng(1).normal(0, shift_m, (len(frames), 3))
    none = np.zeros((0, 3))
    mesh = LabelledMesh(none.astype(np.float32), none.astype(np.uint8), none[:, 0].astype(np.int32), none.astype(int))
    stamps = np.array([frame.stamp for frame in frames])
    panoptic = SimpleNamespace(objects=(), mesh=mesh)
    return SimpleNamespace(trajectory=TimedPoses(stamps, poses), tracked=1.0, panoptic=panoptic)


def test_the_run_whose_camera_strays_is_told_from_the_other_and_alike_ones_are_not(recorded):
    frames, depth = recorded
    true, stray = mapped(frames, 0.0), mapped(frames, 0.05)
    assert pose_figures({"given": stray, "slam": true}, depth).startswith("**slam has the better poses**")
    assert pose_figures({"given": true, "slam": stray}, depth).startswith("**given has the better poses**")
    assert pose_figures({"given": true, "slam": mapped(frames, 0.0005)}, depth).startswith("**No clear difference**")


def test_without_depth_images_nothing_is_claimed(recorded):
    true = mapped(recorded[0], 0.0)
    apart = replace(recorded[1], stamps=recorded[1].stamps + 1000)
    for depth in (None, apart):
        assert "do not tell" in pose_figures({"given": true, "slam": true}, depth)
