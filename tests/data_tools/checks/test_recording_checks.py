"""Each mistake planted in a recording is named with its fix, and a correct recording raises nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from data_tools import open_sequence
from data_tools.checks.inspection import Inspection, inspect_sequence
from data_tools.checks.pose_check import check_poses
from data_tools.checks.pose_conventions import AS_WRITTEN, conventions
from data_tools.checks.rgbd_alignment_check import check_rgbd_alignment
from data_tools.checks.sample import Sample
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.arrays import Float64Array
from razer.frame import Frame
from razer.geometry import inverse, is_rigid
from slam.se3 import exp_se3
from tests.support.spoilt import Spoilt, as_is, depth_moved, mirrored, posed, scaled

OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])
N_FRAMES = 24
CLIPS = ("redkitchen", "tum_fr1_rpy_head")


@pytest.fixture(scope="module")
def room() -> list[Frame]:
    recording = SyntheticRoom(3, n_frames=240, width=320, height=240)
    return [recording[index] for index in range(60, 60 + N_FRAMES)]


@pytest.fixture(scope="module")
def noisy_room() -> list[Frame]:
    recording = SyntheticRoom(4, n_frames=240, width=320, height=240, sensor=SensorModel.kinect())
    return [recording[index] for index in range(60, 60 + N_FRAMES)]


@pytest.fixture(scope="module", params=CLIPS)
def clip(request: pytest.FixtureRequest, real_data: Path) -> Spoilt:
    """The frames of a real clip that the checks look at."""
    recording = open_sequence(real_data / request.param)
    return Spoilt([recording[index] for index in range(0, 2 * N_FRAMES, 2)], as_is, recording.depth_scale)


@pytest.fixture(scope="module")
def room_sample(room: list[Frame]) -> Sample:
    return Sample.of(Spoilt(room, as_is))


@pytest.fixture(scope="module")
def clip_sample(clip: Spoilt) -> Sample:
    return Sample.of(clip)


def spoilt(sample: Sample, change: Callable[[Frame], Frame]) -> Sample:
    """The sample with other frames; motions between images are measured once, and stay what they are."""
    return replace(sample, groups=tuple(tuple(change(frame) for frame in group) for group in sample.groups))


def quaternion_order(pose: Float64Array) -> Float64Array:
    wrong = pose.copy()
    # Written w x y z, read as x y z w.
    wrong[:3, :3] = Rotation.from_quat(np.roll(Rotation.from_matrix(pose[:3, :3]).as_quat(), 1)).as_matrix()
    return wrong


def turned(pose: Float64Array) -> Float64Array:
    """A camera held upright whose images are taken for lying ones: x and y swapped."""
    swap = np.eye(4)
    swap[:2, :2] = [[0, 1], [-1, 0]]
    return pose @ swap


POSE_MISTAKES = {
    "world-to-camera": (inverse, "world-to-camera: invert each 4x4 matrix"),
    "OpenGL": (lambda pose: pose @ OPENGL, "OpenGL's, y up and z backward"),
    "both": (lambda pose: OPENGL @ inverse(pose), "world-to-camera with OpenGL axes"),
    "x and y": (turned, "right, down and forward are their y, -x and z"),
    "quaternions": (quaternion_order, "quaternions are w x y z"),
}


def about(found: Inspection) -> list[str]:
    return [issue.about for issue in found.issues]


def test_nothing_is_said_against_correct_rooms(room: list[Frame], noisy_room: list[Frame]) -> None:
    for frames in (room, noisy_room):
        found = inspect_sequence(Spoilt(frames, as_is))
        assert found.issues == ()
        assert found.poses.n_pairs >= 4
        assert found.rgbd_alignment.clear
        assert not found.rgbd_alignment.noticeable


def test_nothing_is_said_against_real_clips_but_that_redkitchens_colour_is_off(clip: Spoilt) -> None:
    """So few frames do not determine by how much."""
    found = inspect_sequence(clip)
    is_redkitchen = clip.frames[0].intrinsics.fx == 585
    assert about(found) == ["registration"] * is_redkitchen
    assert not found.rgbd_estimate.confident
    assert found.poses.n_pairs >= 4
    assert found.rgbd_alignment.clear


@pytest.mark.parametrize("mistake", POSE_MISTAKES)
def test_wrong_poses_are_named(mistake: str, room_sample: Sample, room: list[Frame]) -> None:
    change, named = POSE_MISTAKES[mistake]
    report = check_poses(spoilt(room_sample, posed(change)))
    assert named in report.convention.fix
    # The convention's own arithmetic undoes the mistake, up to where the world is.
    a, b = (report.convention.world_from_camera(change(room[i].pose)) for i in (0, 9))
    np.testing.assert_allclose(inverse(b) @ a, inverse(room[9].pose) @ room[0].pose, atol=1e-6)


def test_noise_does_not_hide_wrong_poses(noisy_room: list[Frame]) -> None:
    found = inspect_sequence(Spoilt(noisy_room, posed(inverse)))
    assert about(found) == ["poses"]
    assert "invert each 4x4 matrix" in found.issues[0].fix


@pytest.mark.parametrize("mistake", ["world-to-camera", "OpenGL"])
def test_wrong_poses_of_real_clips_are_named(mistake: str, clip_sample: Sample) -> None:
    change, named = POSE_MISTAKES[mistake]
    report = check_poses(spoilt(clip_sample, posed(change)))
    assert named in report.convention.fix
    assert report.agreement[1] > report.agreement[0] + 0.1


@pytest.mark.parametrize("factor", [5.0, 0.2])
def test_wrong_depth_scales_are_named(factor: float, noisy_room: list[Frame]) -> None:
    # Read at 1000 / factor units per metre, depth is too large by the factor: 1000 is right.
    found = inspect_sequence(Spoilt(noisy_room, scaled(factor), 1000 / factor))
    assert about(found) == ["depth scale"]
    assert found.issues[0].fix == "try --depth-scale 1000"


def test_two_mistakes_at_once_are_both_named(room: list[Frame]) -> None:
    found = inspect_sequence(Spoilt(room, lambda frame: scaled(5.0)(posed(inverse)(frame)), 200.0))
    assert about(found) == ["poses", "depth scale"]
    assert "invert" in found.issues[0].fix
    assert found.issues[1].fix == "try --depth-scale 1000"


@pytest.mark.parametrize(("zoom", "shift"), [(1.15, (10.0, 0.0)), (0.85, (0.0, 0.0)), (1.0, (0.0, 10.0))])
def test_depth_of_another_camera_is_named(zoom: float, shift: tuple[float, float], room_sample: Sample) -> None:
    report = check_rgbd_alignment(spoilt(room_sample, depth_moved(zoom, shift)).frames)
    assert report.wrong
    assert report.zoom == pytest.approx(1 / zoom, rel=0.025)
    np.testing.assert_allclose(report.shift_px, -np.array(shift) / zoom, atol=2.5)


@pytest.mark.parametrize(("zoom", "shift"), [(1.15, (20.0, 0.0)), (0.8, (-20.0, 10.0))])
def test_depth_of_another_camera_is_named_on_real_clips(
    zoom: float, shift: tuple[float, float], clip_sample: Sample
) -> None:
    report = check_rgbd_alignment(spoilt(clip_sample, depth_moved(zoom, shift)).frames)
    assert report.wrong
    assert not report.mirrored


def test_mirrored_colour_is_named(room_sample: Sample, clip_sample: Sample) -> None:
    for sample in (room_sample, clip_sample):
        report = check_rgbd_alignment(spoilt(sample, mirrored).frames)
        assert report.wrong
        assert report.mirrored


def test_without_texture_depth_alone_tells(room: list[Frame]) -> None:
    def grey(frame: Frame) -> Frame:
        return replace(frame, rgb=np.full_like(frame.rgb, 128))

    def grey_inverted(frame: Frame) -> Frame:
        return grey(posed(inverse)(frame))

    assert check_poses(Sample.of(Spoilt(room, grey))).convention is AS_WRITTEN
    report = check_poses(Sample.of(Spoilt(room, grey_inverted)))
    assert "invert" in report.convention.fix
    assert np.isnan(report.error_px[0])
    assert not check_rgbd_alignment(Sample.of(Spoilt(room, grey)).frames).clear
    found = inspect_sequence(Spoilt(room, lambda frame: grey(scaled(5.0)(frame)), 200.0))
    assert [issue.fix for issue in found.issues] == ["try --depth-scale 1000"]


def test_what_cannot_be_told_is_not_said(room: list[Frame]) -> None:
    assert inspect_sequence(Spoilt(room[:1], as_is)).issues == ()
    without = [replace(frame, world_from_camera=None) for frame in room]
    found = inspect_sequence(Spoilt(without, as_is, has_poses=False))
    assert (found.issues, found.posed, found.path_m) == ((), 0, None)
    # A camera at rest shows nothing of its axes.
    assert inspect_sequence(Spoilt([room[0]] * 30, as_is)).issues == ()


def test_every_convention_is_a_rigid_change_and_no_two_are_the_same() -> None:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec([0.3, -0.5, 0.8]).as_matrix()
    pose[:3, 3] = 1, 2, -3
    here = np.eye(4)
    moved = [inverse(c.world_from_camera(here)) @ c.world_from_camera(pose) for c in conventions()]
    assert all(is_rigid(motion) for motion in moved)
    for i, one in enumerate(moved):
        assert all(np.abs(one - other).max() > 1e-3 for other in moved[:i])
    assert np.array_equal(moved[0], pose)


def random_pose(pose: Float64Array) -> Float64Array:
    rng = np.random.default_rng(round(1e6 * float(pose[0, 3])) % 2**32)
    return pose @ exp_se3(np.concatenate([rng.normal(0, 1.0, 3), rng.normal(0, 1.0, 3)]))


def noisy_pose(pose: Float64Array) -> Float64Array:
    rng = np.random.default_rng(round(1e6 * float(pose[0, 3])) % 2**32)
    return pose @ exp_se3(np.concatenate([rng.normal(0, 0.005, 3), rng.normal(0, 0.02, 3)]))


@pytest.mark.parametrize(("change", "is_unfit"), [(random_pose, True), (noisy_pose, False)])
def test_poses_that_no_convention_explains_are_said_not_to_fit(
    room: list[Frame], change: Callable[[Float64Array], Float64Array], is_unfit: bool
) -> None:
    found = inspect_sequence(Spoilt(room, posed(change)))
    assert found.poses.is_unfit is is_unfit
    assert ("poses" in about(found)) is is_unfit
    if is_unfit:
        (issue,) = [issue for issue in found.issues if issue.about == "poses"]
        assert "0% of the depth agrees" in issue.problem
        assert issue.fix.startswith("no convention explains it")


def test_a_scale_that_explains_all_is_named_alone(room: list[Frame]) -> None:
    found = inspect_sequence(Spoilt(room, posed(lambda pose: np.vstack([pose[:3] * (1, 1, 1, 3), pose[3:]]))))
    assert about(found) == ["depth scale"]
