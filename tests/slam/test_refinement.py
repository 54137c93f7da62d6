"""Given poses corrected by registration: true ones stay, drift and noise go, one jump is let go, no frame is lost."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from app.timeline.depth_agreement import pair_offsets_m
from data_tools import open_sequence
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from razer.errors import UnusableFrame
from razer.geometry import inverse, is_rigid
from razer.metrics.umeyama import umeyama
from slam.refinement import RefinedPoses
from slam.se3 import angle_deg, length_m
from tests.support.drifting_poses import drifting, jumping, noisy


def errors_m(poses, truth):
    """Distances of positions to the true ones after the best rigid alignment."""
    estimated, true = np.array(poses), np.array(truth)
    aligned = umeyama(estimated[:, :3, 3], true[:, :3, 3]) @ estimated
    return np.linalg.norm(aligned[:, :3, 3] - true[:, :3, 3], axis=1)


def ate_m(poses, truth):
    return float(np.sqrt(np.mean(np.square(errors_m(poses, truth)))))


def refined(frames, given):
    """The poses after refinement by the index of the frame, and those that were reported on the way."""
    poses, reported = RefinedPoses(), {}
    for frame, pose in zip(frames, given, strict=True):
        reported[frame.index] = poses.locate(frame.at(pose))
        reported.update(poses.corrections())
    poses.finish()
    reported.update(poses.corrections())
    return poses, reported


@pytest.fixture(scope="module")
def frames():
    room = SyntheticScene("room", 1, 100, 320, 240, sensor=SensorModel.kinect())
    return [room[i] for i in range(0, 100, 3)]


@pytest.fixture(scope="module")
def truth(frames):
    return [frame.pose for frame in frames]


def listed(poses):
    return [pose for _, pose in sorted(poses.trajectory().items())]


@pytest.fixture(scope="module")
def from_truth(frames, truth):
    return refined(frames, truth)


@pytest.fixture(scope="module")
def from_drift(frames, truth):
    return refined(frames, drifting(truth))


def test_true_poses_stay(truth, from_truth):
    poses, _ = from_truth
    assert ate_m(listed(poses), truth) < 0.002
    off = [inverse(true) @ pose for true, pose in zip(truth, listed(poses), strict=True)]  # not aligned: one world
    assert max(map(length_m, off)) < 0.006
    assert max(map(angle_deg, off)) < 0.2


def test_drift_goes_and_the_world_stays_the_given_one(truth, from_drift):
    poses, _ = from_drift
    given = drifting(truth)
    assert ate_m(given, truth) > 0.025
    assert ate_m(listed(poses), truth) < 0.004
    # Nobody can tell where the world is after a drift, but it is about where the given poses have it.
    moved_m = [length_m(inverse(a) @ b) for a, b in zip(given, listed(poses), strict=True)]
    assert np.median(moved_m) < 0.15


def test_what_is_reported_leads_to_the_refined_trajectory(frames, from_drift):
    poses, reported = from_drift
    assert sorted(reported) == [frame.index for frame in frames]
    for index, pose in poses.trajectory().items():
        assert is_rigid(pose)
        off = inverse(reported[index]) @ pose
        assert (length_m(off) < 0.0021, angle_deg(off) < 0.11) == (True, True)


def test_the_report_has_the_keyframes_and_their_covariances(from_drift):
    poses, _ = from_drift
    graph = poses.report().graph
    assert len(graph.frames) == len(poses.keyframes) == len(graph.covariances)
    assert all(np.linalg.eigvalsh(covariance)[0] > 0 for covariance in graph.covariances.values())


def test_frames_that_show_nothing_go_where_the_given_motion_leads(frames, truth):
    blind = [
        replace(frame, rgb=np.full_like(frame.rgb, 127), depth=np.where(frame.depth > 0, np.float32(3.9), 0))
        if 8 <= n < 14
        else frame
        for n, frame in enumerate(frames[:24])
    ]
    given = drifting(truth[:24])
    poses, _ = refined(blind, given)
    assert len(poses.trajectory()) == 24
    steps = [inverse(a) @ b for a, b in pairwise(listed(poses)[8:14])]
    asked = [inverse(a) @ b for a, b in pairwise(given[8:14])]
    assert max(length_m(inverse(a) @ b) for a, b in zip(asked, steps, strict=True)) < 0.01
    assert ate_m(listed(poses), truth[:24]) < ate_m(given, truth[:24])


def test_a_frame_without_a_pose_is_refused(frames):
    with pytest.raises(UnusableFrame):
        RefinedPoses().locate(replace(frames[0], world_from_camera=None))


@pytest.mark.full
@pytest.mark.parametrize(
    ("spoil", "at_least_m", "at_most_m"),
    [
        (lambda truth: noisy(truth, np.random.default_rng(1)), 0.007, 0.004),
        (lambda truth: jumping(truth, 60), 0.1, 0.004),
        (drifting, 0.03, 0.004),
        (lambda truth: truth, 0.0, 0.002),
    ],
    ids=["noise", "jump", "drift", "truth"],
)
@pytest.mark.parametrize("seed", [1, 3, 5])
def test_errors_of_given_poses_go_in_rooms(seed, spoil, at_least_m, at_most_m):
    room = SyntheticScene("room", seed, 100, 320, 240, sensor=SensorModel.kinect())
    frames = list(room)
    truth = [frame.pose for frame in frames]
    given = spoil(truth)
    poses, _ = refined(frames, given)
    before_m, after_m = ate_m(given, truth), ate_m(listed(poses), truth)
    print(f"room {seed}: ATE {1000 * before_m:.1f} mm as given, {1000 * after_m:.1f} mm refined")
    assert before_m >= at_least_m
    assert after_m < at_most_m


@pytest.mark.full
@pytest.mark.parametrize(
    "spoil",
    [lambda poses: poses, drifting, lambda poses: noisy(poses, np.random.default_rng(1))],
    ids=["as recorded", "drift", "noise"],
)
def test_depth_of_a_real_kitchen_agrees_better_once_its_poses_are_refined(real_data, spoil):
    """KinectFusion's own poses are no truth: how far depth images are apart under poses asks none."""
    clip = open_sequence(real_data / "redkitchen")
    frames = [clip[index] for index in range(0, 600, 5)]
    given = spoil([frame.pose for frame in frames])
    poses, _ = refined(frames, given)
    images = [frame.depth for frame in frames[::4]]
    before, after = (pair_offsets_m(images, clip.intrinsics, np.array(p[::4])) for p in (given, listed(poses)))
    both = np.isfinite(before) & np.isfinite(after)
    before_m, after_m = np.median(before[both]), np.median(after[both])
    moved_m = [length_m(inverse(a) @ b) for a, b in zip(given, listed(poses), strict=True)]
    print(f"depth images are {1000 * before_m:.1f} mm apart as given, {1000 * after_m:.1f} mm refined; "
          f"poses moved by {1000 * np.median(moved_m):.1f} mm")  # fmt: skip
    assert after_m < before_m


def test_a_recording_without_a_frame_has_no_poses():
    poses = RefinedPoses()
    poses.finish()
    assert poses.trajectory() == {}
    assert poses.corrections() == {}
