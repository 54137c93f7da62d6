"""The way of frames to the main loop: in order, through both processes, late ones last."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from app.frames.frame_packet import Located, Lost, Perceived, PosesFinal, PoseUpdate, Unusable
from app.frames.packet_stream import packet_stream
from app.frames.perceiver import Perceiver
from razer.detection.perception import Observation
from razer.errors import UnusableFrame
from razer.frame import Frame, Intrinsics
from razer.stages import stage

CAMERA = Intrinsics(4, 3, 5.0, 5.0, 1.5, 1.0)
ELSEWHERE = np.array([[1.0, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


def blank(index):
    return Frame(index, float(index), np.zeros((3, 4, 3), np.uint8), np.zeros((3, 4), np.float32), CAMERA)


class Clip:
    """Frames of which those in `broken` are unusable."""

    name, intrinsics, has_poses, depth_scale = "clip", CAMERA, False, 1.0

    def __init__(self, length, broken=(), fatal=()):
        self.length, self.broken, self.fatal = length, broken, fatal

    def __len__(self):
        return self.length

    def __getitem__(self, index):
        if index in self.broken:
            raise UnusableFrame(f"frame {index} is torn")
        if index in self.fatal:
            raise RuntimeError("bug")
        return blank(index)


class Nothing:
    """Perception that sees nothing, and says so; frames in `refused` cannot be used."""

    def __init__(self, refused=()):
        self.refused = refused

    def observe(self, frame):
        with stage("segment"):
            if frame.index in self.refused:
                raise UnusableFrame(f"frame {frame.index} is empty")
            return Observation(frame, None, None)


class Everywhere:
    """Poses that lose the frames in `lost`, and know those in `late` when they are finished."""

    def __init__(self, lost=(), late=()):
        self.lost, self.late = lost, late
        self.finished = False

    def locate(self, frame):
        return None if frame.index in self.lost else np.eye(4)

    def finish(self):
        self.finished = True

    def corrections(self):
        return dict.fromkeys(self.late, ELSEWHERE) if self.finished else {}

    def report(self):
        return None


def packets_of(clip, indices, lost=(), late=(), refused=()):
    with packet_stream(clip, indices, partial(Everywhere, lost, late), Nothing(refused)) as packets:
        return list(packets)


def test_packets_come_in_order_with_the_broken_and_lost_ones_named():
    packets = packets_of(Clip(9, broken=(2, 8)), range(0, 9, 2), lost=(4,))
    assert [type(packet) for packet in packets] == [Perceived, Unusable, Lost, Perceived, Unusable, PosesFinal]
    assert [packet.index for packet in packets[:-1]] == [0, 2, 4, 6, 8]
    assert packets[1].reason == "frame 2 is torn"
    assert "lost" in packets[2].reason
    assert not any(packet.is_late for packet in packets if isinstance(packet, Perceived))


def test_a_packet_carries_the_time_of_its_stages():
    packets = packets_of(Clip(3, broken=(1,)), range(3))
    assert list(packets[0].stage_ms) == ["decode", "pose", "segment"]
    assert list(packets[1].stage_ms) == ["decode"]


def test_frames_whose_pose_is_known_in_the_end_come_last_at_that_pose():
    packets = packets_of(Clip(12), range(12), lost=(1, 3, 7, 8), late=(8, 1, 5))
    assert [packet.index for packet in packets[:12]] == list(range(12))
    assert isinstance(packets[12], PosesFinal)
    assert sorted(packets[12].pose_update.corrections) == [1, 5, 8]
    late = packets[13:]
    assert all(isinstance(packet, Perceived) and packet.is_late for packet in late)
    assert [packet.index for packet in late] == [1, 8]  # 5 was never lost, and 3 and 7 still are
    assert all((packet.observation.frame.pose == ELSEWHERE).all() for packet in late)
    assert all(list(packet.stage_ms) == ["decode", "segment"] for packet in late)


class SecondThoughts:
    """Poses that change their mind: of each frame (with its own index) the corrections that come with a later one."""

    def __init__(self, corrections):
        self.by_turn, self.turn = corrections, -1

    def locate(self, frame):
        self.turn = frame.index
        return None if frame.index in (1, 2) else np.eye(4)

    def finish(self):
        self.turn = "end"

    def corrections(self):
        return self.by_turn.pop(self.turn, {})

    def report(self):
        return None


@pytest.mark.parametrize(
    ("corrections", "late"),
    [
        ({3: {1: ELSEWHERE}, 4: {1: None}}, []),  # recovered, and lost again
        ({3: {0: None}, "end": {0: ELSEWHERE}}, [0]),  # used, lost after all, and known in the end
        ({3: {0: None, 1: ELSEWHERE}, "end": {0: None, 2: ELSEWHERE}}, [1, 2]),
    ],
)
def test_late_frames_are_those_that_are_known_in_the_end(corrections, late):
    with packet_stream(Clip(5), range(5), partial(SecondThoughts, corrections), Nothing()) as packets:
        assert [packet.index for packet in packets if isinstance(packet, Perceived) and packet.is_late] == late


def test_a_frame_that_cannot_be_perceived_keeps_what_its_poses_brought():
    update = PoseUpdate({3: np.eye(4)}, given=np.eye(4))
    packet = Perceiver(Nothing(refused=(5,)))(Located(blank(5), pose_update=update, stage_ms={"decode": 2.0}))
    assert isinstance(packet, Unusable)
    assert (packet.index, packet.reason, packet.pose_update) == (5, "frame 5 is empty", update)
    assert not packet.is_late
    assert Perceiver(Nothing(refused=(5,)))(Located(blank(5), is_late=True)).is_late
    assert list(packet.stage_ms) == ["decode", "segment"]


def test_an_error_that_is_no_frames_fault_ends_the_stream():
    with pytest.raises(RuntimeError, match="bug"):
        packets_of(Clip(5, fatal=(1,)), range(5))
