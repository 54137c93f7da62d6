"""Corrections of frames whose keyframe moved, against a look at all frames each time."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from razer.geometry import inverse
from slam.located_frames import MIN_CORRECTION_DEG, MIN_CORRECTION_M, LocatedFrames
from slam.se3 import angle_deg, length_m, orthonormal


def motion(rng: np.random.Generator, size: float) -> np.ndarray:
    result = np.eye(4)
    result[:3, :3] = Rotation.from_rotvec(size * rng.normal(size=3)).as_matrix()
    result[:3, 3] = size * rng.normal(size=3)
    return result


class Keyframes:
    """As much of a map of keyframes as frames need; counts the poses it was asked for."""

    def __init__(self, n: int) -> None:
        rng = np.random.default_rng(n)
        poses = [motion(rng, 1.0) for _ in range(n)]
        self.all = [SimpleNamespace(number=i, submap=0, world_from_camera=pose) for i, pose in enumerate(poses)]
        self.keyframes: Any = self
        self.version = self.n_asked = 0

    def __getitem__(self, number: int) -> SimpleNamespace:
        return self.all[number]

    def poses(self) -> np.ndarray:
        return np.stack([keyframe.world_from_camera for keyframe in self.all])

    def submaps(self) -> np.ndarray:
        return np.array([keyframe.submap for keyframe in self.all])

    def pose(self, keyframe: int, keyframe_from_camera: np.ndarray) -> np.ndarray:
        self.n_asked += 1
        return orthonormal(self.all[keyframe].world_from_camera @ keyframe_from_camera)


def slow_corrections(frames: LocatedFrames, reported: dict[int, np.ndarray | None]) -> dict[int, np.ndarray | None]:
    """Looks at all frames; `reported` is what was told of each so far."""
    poses, changed = frames.trajectory(), dict[int, np.ndarray | None]()
    for index, before in reported.items():
        pose = poses.get(index)
        if pose is None or before is None:
            if pose is not before:
                changed[index] = pose
            continue
        offset = inverse(before) @ pose
        if length_m(offset) > MIN_CORRECTION_M or angle_deg(offset) > MIN_CORRECTION_DEG:
            changed[index] = pose
    return changed


@pytest.mark.parametrize("seed", range(4))
def test_corrections_are_those_of_a_look_at_all_frames(seed: int) -> None:
    rng = np.random.default_rng(seed)
    keyframes = Keyframes(12)
    frames, reported = LocatedFrames(keyframes), dict[int, np.ndarray | None]()  # type: ignore[arg-type]
    n_changed = 0
    for step in range(120):
        at = keyframes[int(rng.integers(12))]
        reported[step] = frames.add(step, at, motion(rng, 0.2))  # type: ignore[arg-type]
        for keyframe in rng.choice(12, int(rng.integers(0, 4)), replace=False).tolist():
            size = float(rng.choice([1e-12, 2e-4, 2e-3, 0.1]))
            keyframes[keyframe].world_from_camera = motion(rng, size) @ keyframes[keyframe].world_from_camera
        if step % 10 == 7:
            moved = keyframes[int(rng.integers(12))]
            moved.submap = 1 - moved.submap
        if rng.random() < 0.6:
            keyframes.version += 1
            expected = slow_corrections(frames, reported)
            corrections = frames.corrections()
            assert corrections.keys() == expected.keys()
            for index, pose in expected.items():
                np.testing.assert_array_equal(corrections[index], pose)
                assert frames.reported(index) is corrections[index]
            reported |= corrections
            n_changed += len(corrections)
    assert n_changed > 200
    assert frames.corrections() == {}


def test_a_pose_that_changed_and_went_back_between_two_looks_is_corrected() -> None:
    keyframes = Keyframes(1)
    frames = LocatedFrames(keyframes)  # type: ignore[arg-type]
    keyframes.version += 1
    frames.corrections()
    first = keyframes[0].world_from_camera
    keyframes[0].world_from_camera = motion(np.random.default_rng(0), 0.1) @ first
    frames.add(0, keyframes[0], np.eye(4))  # type: ignore[arg-type]
    keyframes[0].world_from_camera = first
    keyframes.version += 1
    np.testing.assert_allclose(frames.corrections()[0], first)


def test_only_frames_of_keyframes_that_moved_are_looked_at() -> None:
    keyframes = Keyframes(50)
    frames = LocatedFrames(keyframes)  # type: ignore[arg-type]
    for index in range(500):
        frames.add(index, keyframes[index % 50], np.eye(4))  # type: ignore[arg-type]
    keyframes.version += 1
    frames.corrections()
    keyframes[7].world_from_camera = np.eye(4)
    keyframes.version += 1
    keyframes.n_asked = 0
    assert set(frames.corrections()) == set(range(7, 500, 50))
    assert keyframes.n_asked == 10


def test_frames_are_not_looked_at_again_for_less_than_is_reported_and_are_once_it_adds_up() -> None:
    keyframes, rng = Keyframes(30), np.random.default_rng(0)
    frames = LocatedFrames(keyframes)  # type: ignore[arg-type]
    for index in range(300):
        frames.add(index, keyframes[index % 30], motion(rng, 0.2))  # type: ignore[arg-type]
    n_asked, corrected = list[int](), set[int]()
    for _ in range(60):
        for keyframe in keyframes.all:
            pose = keyframe.world_from_camera.copy()
            pose[0, 3] += 1e-4
            keyframe.world_from_camera = pose
        keyframes.version += 1
        keyframes.n_asked = 0
        corrected |= frames.corrections().keys()
        n_asked.append(keyframes.n_asked)
    assert n_asked[0] == 300  # which nobody had looked at
    assert sum(n_asked[1:]) <= 59 * 1e-4 / MIN_CORRECTION_M * 300 * 2
    assert corrected == set(range(300))


def test_a_trajectory_is_in_the_order_of_frames_whenever_they_were_located() -> None:
    keyframes = Keyframes(2)
    frames = LocatedFrames(keyframes)  # type: ignore[arg-type]
    for index in (4, 7, 2, 5):
        frames.add_late(index, keyframes[index % 2], motion(np.random.default_rng(index), 0.1))  # type: ignore[arg-type]
    assert list(frames.trajectory()) == [2, 4, 5, 7]


def test_a_frame_that_is_located_late_is_told_of_though_no_keyframe_moved() -> None:
    keyframes = Keyframes(1)
    frames = LocatedFrames(keyframes)  # type: ignore[arg-type]
    frames.add(1, keyframes[0], np.eye(4))  # type: ignore[arg-type]
    keyframes.version += 1
    frames.corrections()
    frames.add_late(0, keyframes[0], np.eye(4))  # type: ignore[arg-type]
    (told,) = frames.corrections().items()
    assert told[0] == 0
    np.testing.assert_allclose(told[1], keyframes[0].world_from_camera)
    assert frames.corrections() == {}
