"""Recordings without colour, as in the dark: depth alone is followed, where it leaves no direction open."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from data_tools import open_sequence
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from razer.frame import Frame, Intrinsics
from razer.geometry import inverse
from slam.frontend.features import FeatureExtractor
from slam.se3 import angle_deg, length_m
from slam.system import SlamSystem

CAMERA = Intrinsics(320, 240, 260.0, 260.0, 159.5, 119.5)
BLACK = np.zeros((240, 320, 3), np.uint8)
U, V = (np.arange(320)[None] - 159.5) / 260 + np.zeros((240, 1)), (np.arange(240)[:, None] - 119.5) / 260


@pytest.fixture(scope="module")
def room():
    return SyntheticScene("room", 1, 100, 320, 240, sensor=SensorModel.kinect())


def dark(frame):
    return replace(frame, rgb=np.zeros_like(frame.rgb), world_from_camera=None)


def located(frames):
    slam = SlamSystem()
    poses = [slam.locate(frame) for frame in frames]
    slam.finish()
    return poses, slam


def off_by(slam, first, last):
    """Metres and degrees by which the motion between two frames is wrong."""
    poses = slam.trajectory()
    found = inverse(poses[first.index]) @ poses[last.index]
    off = inverse(inverse(first.pose) @ last.pose) @ found
    return length_m(off), angle_deg(off)


def test_a_dark_room_is_followed_by_its_depth(room):
    frames = [room[index] for index in range(70)]
    poses, slam = located([dark(frame) for frame in frames])
    assert all(pose is not None for pose in poses)
    away_m = length_m(inverse(frames[0].pose) @ frames[-1].pose)
    off_m, off_deg = off_by(slam, frames[0], frames[-1])
    assert off_m < min(0.02, away_m / 10)
    assert off_deg < 0.5


def test_a_dark_kitchen_is_followed_by_its_depth(real_data):
    clip = open_sequence(real_data / "redkitchen")
    frames = [clip[index] for index in range(0, 240, 4)]
    poses, slam = located([dark(frame) for frame in frames])
    assert all(pose is not None for pose in poses)
    off_m, off_deg = off_by(slam, frames[0], frames[-1])
    assert off_m < 0.06
    assert off_deg < 3


def test_a_camera_goes_on_while_the_light_is_off(room):
    frames = [room[index] for index in range(60)]
    poses, slam = located([dark(frame) if 20 <= frame.index < 40 else frame.at(np.eye(4)) for frame in frames])
    assert all(pose is not None for pose in poses)
    assert {keyframe.submap for keyframe in slam.keyframes.all} == {0}
    assert off_by(slam, frames[0], frames[-1])[0] < 0.02


WALL = np.full((240, 320), 2.0)
CORRIDOR = 1 / np.maximum(np.abs(U), 1e-3)  # walls a metre to the left and right, along the axis of the camera
CORNER = np.minimum(2.0, np.minimum(1 / np.maximum(np.abs(U), 1e-3), 0.8 / np.maximum(V, 1e-3)))  # and an end, a floor


@pytest.mark.parametrize(
    ("depth", "begins"), [(WALL, False), (CORRIDOR, False), (CORNER, True)], ids=["wall", "corridor", "corner"]
)
def test_depth_that_leaves_a_direction_open_begins_nothing(depth, begins):
    seen = np.where(depth < 6, depth, 0).astype(np.float32)
    poses, _ = located([Frame(0, 0.0, BLACK, seen, CAMERA)])
    assert (poses[0] is not None) == begins


def test_a_hand_before_the_lens_begins_nothing(room):
    """Frames 30 to 59 show what depth alone would hold; that the room has colour says that it is none of it."""
    hand = Frame(0, 0.0, np.full_like(BLACK, 90), (0.3 * CORNER).astype(np.float32), CAMERA)
    assert located([hand])[0][0] is not None
    frames = [room[index].at(np.eye(4)) for index in range(30)]
    covered = [replace(hand, index=index, stamp=index / 30) for index in range(30, 60)]
    again = [replace(frame, index=40 + frame.index, stamp=4 / 3 + frame.stamp) for frame in frames[20:]]
    poses, slam = located([*frames, *covered, *again])
    assert poses[30:60] == [None] * 30
    assert slam.trajectory().keys() >= {frame.index for frame in again}
    assert {keyframe.submap for keyframe in slam.keyframes.all} == {0}


def test_the_frames_have_no_corners(room):
    extracted = FeatureExtractor(SlamSystem().config).extract(dark(room[0]), SlamSystem().calibration)
    assert len(extracted) == 0
