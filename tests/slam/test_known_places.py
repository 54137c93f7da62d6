"""A camera that comes back to what it has seen is followed from the keyframes that it left there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from data_tools import open_sequence
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from razer.metrics.umeyama import umeyama
from slam.system import SlamSystem

N = 60  # frames of the way, of which every other is shown, to and fro


@pytest.fixture(scope="module")
def room():
    return SyntheticScene("room", 3, 120, 320, 240, sensor=SensorModel.kinect())


def followed(frames, n_ways):
    """What is followed along the frames and back, so many ways in all, and how many keyframes there were after each."""
    slam, n_keyframes, number = SlamSystem(), [], 0
    for way in range(n_ways):
        for frame in frames[::-1] if way % 2 else frames:
            assert slam.locate(replace(frame, index=number, stamp=number / 15, world_from_camera=None)) is not None
            number += 1
        n_keyframes.append(len(slam.keyframes))
    slam.finish()
    return slam, n_keyframes


def errors_m(slam, frames):
    poses = slam.trajectory()
    truth = np.stack([(frames[::-1] if n // len(frames) % 2 else frames)[n % len(frames)].pose for n in sorted(poses)])
    found = np.stack([poses[n] for n in sorted(poses)])
    aligned = umeyama(found[:, :3, 3], truth[:, :3, 3]) @ found
    return np.linalg.norm(aligned[:, :3, 3] - truth[:, :3, 3], axis=1)


def test_a_way_that_is_gone_again_needs_no_further_keyframes(room):
    frames = [room[index] for index in range(0, N, 2)]
    slam, n_keyframes = followed(frames, 4)
    assert n_keyframes[0] >= 5
    assert n_keyframes[-1] <= n_keyframes[0] + 2
    errors = errors_m(slam, frames)
    assert len(errors) == 4 * len(frames)
    assert errors.max() < 0.01
    assert errors[-len(frames) :].mean() < 2 * errors[: len(frames)].mean() + 0.001


@pytest.mark.full
def test_a_kitchen_that_is_seen_again_needs_few_further_keyframes(real_data):
    clip = open_sequence(real_data / "redkitchen")
    frames = [clip[index] for index in range(0, 160, 4)]
    slam, n_keyframes = followed(frames, 3)
    assert n_keyframes[-1] <= 1.5 * n_keyframes[0]
    assert np.sqrt(np.mean(errors_m(slam, frames) ** 2)) < 0.03


@pytest.fixture(scope="module")
def sure(room):
    """The frames of a way, and how many keyframes there were after it, and after the way back."""
    frames = [room[index] for index in range(0, N, 2)]
    return frames, followed(frames, 2)[1]


@pytest.mark.parametrize("doubt", ["untrusted", "open", "untied"])
def test_a_keyframe_that_the_view_does_not_surely_fit_is_not_gone_back_to(sure, monkeypatch, doubt):
    frames, n_sure = sure
    if doubt == "untied":
        monkeypatch.setattr("slam.backend.keyframe_map.KeyframeMap.tie", lambda *_: False)
    else:
        name, answer = ("is_trusted", False) if doubt == "untrusted" else ("leaves_open", True)
        monkeypatch.setattr(f"slam.system.{name}", lambda _: answer)
    slam, unsure = followed(frames, 2)
    assert unsure[0] == n_sure[0]
    assert unsure[1] - unsure[0] > 2 * (n_sure[1] - n_sure[0]) + 2
    assert len(slam.trajectory()) == 2 * len(frames)
