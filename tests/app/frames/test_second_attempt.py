"""A short recording whose frames come in no order: the camera is lost, and in the end all are matched with each
other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.frames.frame_packet import AfterLastFrame, Located, Lost, NothingRecovered, PosesFinal
from app.frames.locator import Locator
from app.frames.second_attempt import SecondAttempt
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from razer.errors import UnusableFrame
from razer.geometry import inverse
from slam.config import SlamConfig
from slam.se3 import length_m
from slam.system import SlamSystem

ORDER = (0, 7, 3, 9, 1, 5, 8, 2, 6, 4)
UNUSABLE = 4


class Unordered:
    """Pictures of a room, 0.3 m and 15 degrees apart, in no order; one cannot be used."""

    def __init__(self):
        clip = SyntheticScene("room", 2, 480, 320, 240, sensor=SensorModel.kinect())
        self.shots = [clip[20 * n] for n in ORDER]

    def __getitem__(self, index):
        if index == UNUSABLE:
            raise UnusableFrame("torn")
        return replace(self.shots[index], index=index, stamp=index / 30, world_from_camera=None)


@pytest.mark.full
def test_where_the_camera_was_lost_all_frames_are_located_in_the_end():
    clip, n = Unordered(), len(ORDER)
    locator = Locator(clip, SlamSystem, second_attempt=SecondAttempt(clip, range(n), SlamConfig()))
    packets = [locator(index) for index in range(n)]
    lost = {packet.index for packet in packets if isinstance(packet, Lost)}
    assert len(lost) > n / 3
    final = locator(AfterLastFrame.FINISH_POSES)
    assert isinstance(final, PosesFinal)
    assert "matched with each other" in final.note
    poses = final.pose_update.corrections
    assert poses.keys() == set(range(n)) - {UNUSABLE}
    for index, pose in poses.items():
        true = inverse(clip.shots[0].pose) @ clip.shots[index].pose
        assert length_m(inverse(true) @ pose) < 0.02
    late = []
    while not isinstance(packet := locator(AfterLastFrame.NEXT_RECOVERED), NothingRecovered):
        assert isinstance(packet, Located)
        np.testing.assert_array_equal(packet.frame.pose, poses[packet.index])
        late.append(packet.index)
    assert set(late) == lost
    assert len(final.pose_update.report.graph.frames) == n - 1


def test_nothing_is_done_where_the_camera_was_followed():
    assert SecondAttempt(None, range(10), SlamConfig())(1) is None
