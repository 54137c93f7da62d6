"""Poses from images alone: real and synthetic recordings, loss and recovery, input that shows nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from app.frames.frame_packet import AfterLastFrame, Located, Lost, NothingRecovered, PosesFinal
from app.frames.locator import Locator
from data_tools import open_sequence
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from razer.frame import Frame, Intrinsics
from razer.geometry import inverse, is_rigid, rotation_error
from razer.metrics.umeyama import umeyama
from slam.backend.submaps.placement_check import PlacementCheck
from slam.frontend.features import FeatureExtractor
from slam.frontend.keyframes import STILL, View
from slam.poses import GivenPoses
from slam.se3 import angle_deg, length_m
from slam.system import SlamSystem

CAMERA = Intrinsics(320, 240, 260.0, 260.0, 159.5, 119.5)


def errors_m(poses, truth):
    """Distances of estimated positions to the true ones after the best rigid alignment, by index."""
    indices = sorted(poses)
    estimated = np.stack([poses[i] for i in indices])
    true = np.stack([truth[i] for i in indices])
    aligned = umeyama(estimated[:, :3, 3], true[:, :3, 3]) @ estimated
    return np.linalg.norm(aligned[:, :3, 3] - true[:, :3, 3], axis=1)


def root_mean_square(values):
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.fixture(scope="module")
def room():
    return SyntheticScene("room", 1, 100, 320, 240, sensor=SensorModel.kinect())


@pytest.fixture(scope="module", params=[5, pytest.param(1, marks=pytest.mark.full)])
def two_corners(request):
    """A room of which frames 60 to 75 show nothing that the first ten do; at seed 5 a corner that is like another one
    but for its colours."""
    return SyntheticScene("room", request.param, 100, 320, 240, sensor=SensorModel.kinect())


@pytest.fixture(scope="module")
def frames(room):
    return [room[i] for i in range(70)]


@pytest.fixture(scope="module")
def tracked(frames):
    slam, reported = SlamSystem(), {}
    for frame in frames:
        reported[frame.index] = slam.locate(frame.at(np.eye(4)))
        reported.update(slam.corrections())
    slam.finish()
    reported.update(slam.corrections())
    return slam, reported


def test_a_simulated_room_is_tracked_within_centimetres(frames, tracked):
    slam, reported = tracked
    assert sorted(reported) == [frame.index for frame in frames]
    assert all(pose is not None and is_rigid(pose) for pose in reported.values())
    truth = {frame.index: frame.pose for frame in frames}
    assert root_mean_square(errors_m(slam.trajectory(), truth)) < 0.02
    np.testing.assert_allclose(slam.trajectory()[0], np.eye(4), atol=1e-6)


def test_the_corrections_lead_to_the_final_trajectory(tracked):
    slam, reported = tracked
    for index, pose in slam.trajectory().items():
        off = inverse(reported[index]) @ pose
        assert length_m(off) < 0.0021
        assert angle_deg(off) < 0.11


def test_keyframes_are_fewer_than_frames_and_edges_connect_them(frames, tracked):
    slam, _ = tracked
    assert 3 <= len(slam.keyframes) < len(frames) / 2
    connected = {edge.b for edge in slam.graph.edges if edge.is_odometry}
    assert connected == set(range(1, len(slam.keyframes)))


def test_rounding_does_not_grow_from_frame_to_frame(tracked):
    """A guess is made of the motion before, and that of its guess."""
    slam, _ = tracked
    assert max(rotation_error(edge.a_from_b[:3, :3]) for edge in slam.graph.edges) < 1e-12


@pytest.mark.parametrize(("stride", "gap_s"), [(16, 16 / 30), (8, 1 / 30)], ids=["half a second", "wrong stamps"])
def test_pictures_a_step_and_many_degrees_apart_are_all_located(stride, gap_s):
    """0.2 m and 12 degrees from one to the next, or half of that with stamps as if they were of a video, by which the
    camera would turn at 180 degrees a second and smear its depth, which fits as sharply as ever."""
    clip, slam = SyntheticScene("room", 2, 480, 320, 240, sensor=SensorModel.kinect()), SlamSystem()
    shots = [clip[index] for index in range(0, 20 * stride, stride)]
    posed = [slam.locate(replace(shot, stamp=n * gap_s, world_from_camera=None)) for n, shot in enumerate(shots)]
    assert all(pose is not None for pose in posed)
    slam.finish()
    assert root_mean_square(errors_m(slam.trajectory(), {shot.index: shot.pose for shot in shots})) < 0.01


def test_a_real_kitchen_is_tracked(real_data):
    clip = open_sequence(real_data / "redkitchen")
    slam, truth = SlamSystem(), {}
    for index in range(0, 240, 4):
        frame = clip[index]
        truth[index] = frame.pose
        assert slam.locate(replace(frame, world_from_camera=None)) is not None
    slam.finish()
    assert root_mean_square(errors_m(slam.trajectory(), truth)) < 0.03


@pytest.mark.parametrize("backwards", [False, True])
def test_a_camera_that_turns_fast_is_never_lost_and_its_readout_is_learnt(real_data, backwards):
    """freiburg1_rpy, up to 110 degrees a second. Played backwards, its rows are read in the other order."""
    clip = open_sequence(real_data / "tum_fr1_rpy_head")
    frames = [clip[index] for index in range(len(clip))]
    shots, slam = frames[::-1] if backwards else frames, SlamSystem()
    assert all(pose is not None for pose in located_in_time(slam, shots))
    slam.finish()
    poses = slam.trajectory()
    assert root_mean_square(errors_m(poses, [shot.pose for shot in shots])) < 0.02
    estimated = Rotation.from_matrix([poses[n][:3, :3] for n in range(len(shots))])
    off = Rotation.from_matrix([shot.pose[:3, :3] for shot in shots]) * estimated.inv()
    assert np.degrees(root_mean_square((off.mean().inv() * off).magnitude())) < 1.5
    readout_s = slam.calibration.parameters[6]
    assert -0.03 < readout_s < -0.005 if backwards else 0.005 < readout_s < 0.03


def located_in_time(slam, shots):
    """The pose reported for each shot, at the intervals they were taken at."""
    return [
        slam.locate(replace(shot, index=n, stamp=abs(shot.stamp - shots[0].stamp), world_from_camera=None))
        for n, shot in enumerate(shots)
    ]


def blank(frame):
    return replace(frame, rgb=np.zeros_like(frame.rgb), depth=np.zeros_like(frame.depth))


def located(slam, shots, start):
    """The pose reported for each shot; shots are numbered from `start` and carry no pose of their own."""
    return [
        slam.locate(replace(shot, index=start + n, stamp=(start + n) / 30, world_from_camera=None))
        for n, shot in enumerate(shots)
    ]


def test_a_camera_that_went_blind_is_found_again_where_it_has_been(frames):
    slam = SlamSystem()
    assert all(pose is not None for pose in located(slam, frames[:40], 0))
    assert located(slam, [blank(frame) for frame in frames[:40]], 40) == [None] * 40
    poses = located(slam, frames[5:25], 80)
    assert all(pose is not None for pose in poses[10:])
    truth = inverse(frames[0].pose) @ frames[24].pose
    assert length_m(inverse(truth) @ poses[-1]) < 0.05


def test_a_camera_that_went_blind_for_a_moment_goes_on(frames):
    slam = SlamSystem()
    located(slam, frames[:20], 0)
    located(slam, [blank(frame) for frame in frames[20:23]], 20)
    poses = located(slam, frames[23:26], 23)
    assert all(pose is not None for pose in poses)
    assert all(keyframe.submap == 0 for keyframe in slam.keyframes.all)
    truth = inverse(frames[0].pose) @ frames[25].pose
    assert length_m(inverse(truth) @ poses[-1]) < 0.06


def test_a_place_never_seen_is_a_submap_of_its_own_until_views_of_both_merge_it(two_corners):
    slam = SlamSystem()
    shots = [two_corners[i] for i in range(75)]
    located(slam, shots[:10], 0)
    located(slam, [blank(shots[0])] * 12, 10)
    away = located(slam, shots[60:75], 22)
    # A new submap is tracked, but no pose is reported that hangs in the air.
    assert away == [None] * 15
    assert {keyframe.submap for keyframe in slam.keyframes.all} == {0, 1}
    assert sorted(slam.trajectory()) == list(range(10))
    back = located(slam, shots[73::-1], 37)
    assert back[-1] is not None
    slam.finish()
    assert {keyframe.submap for keyframe in slam.keyframes.all} == {0}
    truth = {n: shot.pose for n, shot in enumerate(shots[:10])}
    truth |= {22 + n: shot.pose for n, shot in enumerate([*shots[60:75], *shots[73::-1]])}
    poses = slam.trajectory()
    # Those that were passed over, in the hope that the next would show something known, were located afterwards.
    assert poses.keys() == truth.keys()
    assert root_mean_square(errors_m(poses, truth)) < 0.06


def test_the_submap_that_shows_most_frames_is_the_world_in_the_end(room):
    slam = SlamSystem()
    assert all(pose is not None for pose in located(slam, [room[i] for i in range(3)], 0))
    located(slam, [blank(room[0])] * 3, 3)
    assert located(slam, [room[i] for i in range(60, 75)], 6) == [None] * 15
    slam.corrections()
    slam.finish()
    changed = slam.corrections()
    assert [index for index, pose in changed.items() if pose is None] == [0, 1, 2]
    poses = {index: pose for index, pose in changed.items() if pose is not None}
    assert min(poses) > 5
    assert slam.trajectory().keys() == poses.keys()
    truth = {6 + n: room[60 + n].pose for n in range(15)}
    assert root_mean_square(errors_m(poses, {n: truth[n] for n in poses})) < 0.03
    graph = slam.report().graph
    assert graph.n_unanchored == 1
    # What is the world is certain where it begins.
    first = min(graph.covariances)
    assert np.trace(graph.covariances[first]) < 1e-6


NO_TIES = np.zeros((0, 2), np.int64)


def test_a_merge_is_refused_if_views_around_would_stand_where_others_saw_through(frames):
    slam = SlamSystem()
    located(slam, frames[:12], 0)
    frame = replace(frames[6], index=20, world_from_camera=None)
    features = FeatureExtractor(slam.config).extract(frame, slam.calibration)
    alone = slam.map.begin_submap(View.of(frame, features, STILL, slam.config), 0.0)
    true = inverse(frames[0].pose) @ frames[6].pose
    nearer = true.copy()
    nearer[:3, 3] -= 0.5 * true[:3, 2]
    placement = PlacementCheck(slam.keyframes, slam.graph, slam.config)
    for where, refused in ((true, False), (nearer, True)):
        shift = where @ inverse(alone.world_from_camera)
        assert placement.contradicts([alone.number], np.arange(alone.number), shift, NO_TIES) == refused


class TwoSubmaps:
    """A room of which the camera sees a part, nothing, another part, and then, on its way back, both."""

    def __init__(self, room):
        order = [*range(10), *[None] * 6, *range(60, 75), *range(73, 4, -1)]
        self.shots = [blank(room[0]) if i is None else room[i] for i in order]

    def __getitem__(self, index):
        return replace(self.shots[index], index=index, stamp=index / 30, world_from_camera=None)


@pytest.mark.full
def test_frames_of_a_submap_that_is_merged_later_come_late_at_their_final_poses(two_corners):
    locator = Locator(TwoSubmaps(two_corners), SlamSystem)
    packets = [locator(index) for index in range(len(locator.sequence.shots))]
    lost = [packet.index for packet in packets if isinstance(packet, Lost)]
    assert set(range(20, 28)) < set(lost)
    assert isinstance(locator(AfterLastFrame.FINISH_POSES), PosesFinal)
    late = []
    while not isinstance(packet := locator(AfterLastFrame.NEXT_RECOVERED), NothingRecovered):
        late.append(packet)
    assert all(isinstance(packet, Located) and packet.is_late for packet in late)
    found = [packet.index for packet in late]
    assert found == [index for index in lost if index >= 16]  # all but the blank ones
    for packet in late:
        np.testing.assert_allclose(packet.frame.pose, locator.poses.trajectory()[packet.index], atol=0.0025)
    assert isinstance(locator(AfterLastFrame.NEXT_RECOVERED), NothingRecovered)


def frame_of(index, rgb, depth):
    return Frame(index, index / 30, rgb, depth, CAMERA)


def shots(n, make):
    return [make(i) for i in range(n)]


GRAY, NOTHING = np.full((240, 320, 3), 128, np.uint8), np.zeros((240, 320), np.float32)
WALL = np.full((240, 320), 2.0, np.float32)
NOISE = np.random.default_rng(0).integers(0, 255, (240, 320, 3)).astype(np.uint8)


NOWHERE, STILL_THERE = None, np.eye(4)


@pytest.mark.parametrize(
    ("clip", "expected"),
    [
        (shots(5, lambda i: frame_of(i, GRAY, WALL)), [NOWHERE] * 5),
        (shots(5, lambda i: frame_of(i, NOISE, NOTHING)), [NOWHERE] * 5),
        (shots(5, lambda i: frame_of(i, np.zeros_like(GRAY), NOTHING)), [NOWHERE] * 5),
        (shots(5, lambda i: frame_of(5 - i, NOISE, WALL)), [STILL_THERE] * 5),
        # What no camera does between two frames is no motion of any: colour slides by 78 cm, the wall flees by 1 m.
        (
            shots(5, lambda i: frame_of(i, np.roll(NOISE, 90 * i, axis=1), WALL + i)),
            [STILL_THERE, NOWHERE, NOWHERE, NOWHERE, NOWHERE],
        ),
        # And it is found again once it shows what it showed before.
        (
            shots(4, lambda i: frame_of(i, np.roll(NOISE, 90 * (i % 3), axis=1), WALL + i % 3)),
            [STILL_THERE, NOWHERE, NOWHERE, STILL_THERE],
        ),
    ],
    ids=["bare wall", "no depth", "black", "stamps backwards", "huge jumps", "huge jumps and back"],
)
def test_frames_that_show_no_motion_get_no_pose_but_where_the_camera_stood(clip, expected):
    slam = SlamSystem()
    poses = [slam.locate(frame) for frame in clip]
    assert [pose is None for pose in poses] == [pose is None for pose in expected]
    slam.finish()
    final = [slam.trajectory().get(frame.index) for frame in clip]
    for pose in [pose for pose in (*poses, *final) if pose is not None]:
        assert length_m(pose) < 1e-3
        assert angle_deg(pose) < 0.05
    assert [pose is None for pose in final] == [pose is None for pose in expected]


def test_two_identical_frames_stand_still(frames):
    slam = SlamSystem()
    poses = [slam.locate(replace(frames[0], index=i)) for i in range(2)]
    assert length_m(inverse(poses[0]) @ poses[1]) < 1e-3


def test_given_poses_are_final(frames):
    poses = GivenPoses()
    assert poses.locate(frames[0]) is frames[0].world_from_camera
    poses.finish()
    assert poses.corrections() == {}
    assert poses.report() is None
