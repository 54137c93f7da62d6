"""The main loop: what each packet does to the map, the timeline and the account."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from app.frames.frame_accounting import FrameAccounting
from app.frames.frame_packet import Lost, Perceived, PosesFinal, PoseUpdate, Unusable
from app.pipeline.main_loop import map_frames
from app.profiling.recorder import Recorder
from razer.detection.perception import Observation
from razer.errors import BadInput
from razer.frame import Frame, Intrinsics
from slam.report import PoseReport

CAMERA = Intrinsics(4, 3, 5.0, 5.0, 1.5, 1.0)
GRAPH = SimpleNamespace(n_unanchored=0, local_sigmas_m={0: 0.04, 3: 0.001})
CONFIG = SimpleNamespace(voxels=SimpleNamespace(voxel_size_m=0.02))


class Calls:
    """A mapper and a timeline that write down how they are called."""

    config = CONFIG

    def __init__(self):
        self.calls = []

    def move(self, corrections):
        self.calls.append(("move", sorted(corrections)))

    def weigh(self, weights):
        self.calls.append(("weigh", weights))

    def fuse(self, observation):
        self.calls.append(("fuse", observation.frame.index))

    def show(self, frame, step, mapper, stage_ms):
        assert stage_ms["decode"] == 2.0
        self.calls.append(("show", frame.index))

    def track(self, frame_index, report, *, corrections, given):
        self.calls.append(("track", frame_index))

    def skipped(self, frame_index, reason):
        self.calls.append(("skipped", frame_index, reason))

    def finish_tracking(self, report, corrections):
        self.calls.append(("finish_tracking", sorted(corrections)))


def perceived(index, corrections=(), is_late=False):
    rgb, depth = np.zeros((3, 4, 3), np.uint8), np.zeros((3, 4), np.float32)
    frame = Frame(index, index / 30, rgb, depth, CAMERA, np.eye(4))
    update = PoseUpdate(dict(corrections))
    stage_ms = {"decode": 2.0, "pose": 3.0}
    return Perceived(Observation(frame, None, None), pose_update=update, stage_ms=stage_ms, is_late=is_late)


def mapped(packets, max_bad=1.0):
    calls, accounting, recorder = Calls(), FrameAccounting("clip", 10, max_bad), Recorder(10, lambda: 0)
    map_frames(packets, calls, calls, recorder, accounting)
    return calls.calls, accounting, recorder.timings()


def test_each_packet_takes_its_way():
    final = PoseUpdate({0: 2 * np.eye(4), 1: np.eye(4)}, report=PoseReport(None, None, GRAPH))
    calls, accounting, timings = mapped(
        [
            perceived(0),
            Lost(1, stage_ms={"pose": 4.0}),
            Unusable(2, "torn"),
            perceived(3, corrections={0: 3 * np.eye(4)}),
            PosesFinal(final),
            perceived(1, is_late=True),
        ]
    )
    assert calls == [
        ("track", 0), ("fuse", 0), ("show", 0),
        ("track", 1), ("skipped", 1, "lost: the camera could not be located"),
        ("track", 2), ("skipped", 2, "torn"),
        ("move", [0]), ("track", 3), ("fuse", 3), ("show", 3),
        ("move", [0, 1]), ("finish_tracking", [0, 1]),
        ("weigh", {0: 0.25, 1: 0.25}), ("fuse", 1),  # the timeline has passed it
    ]  # fmt: skip
    assert accounting.indices == [0, 1, 3]
    assert [pose[0, 0] for pose in accounting.poses] == [2, 1, 1]
    assert accounting.lost == set()
    assert [(skipped.frame, skipped.reason) for skipped in accounting.skipped] == [(2, "torn")]
    assert accounting.graph is GRAPH
    assert timings["frames"] == 4 == accounting.account().frames  # a frame that comes late was counted in its turn


def test_a_frame_that_stays_lost_is_counted_as_such():
    _, accounting, _ = mapped([perceived(0), Lost(1), PosesFinal(PoseUpdate())])
    assert accounting.lost == {1}
    assert accounting.graph is None


def test_a_late_frame_that_cannot_be_perceived_counts_once():
    _, accounting, timings = mapped(
        [perceived(0), Lost(1), PosesFinal(PoseUpdate({1: np.eye(4)})), Unusable(1, "its mask is torn", is_late=True)]
    )
    account = accounting.account()
    assert (account.frames, account.used, account.lost, len(account.skipped)) == (2, 1, 0, 1)
    assert timings["frames"] == 2


def test_too_many_unusable_frames_end_the_run():
    with pytest.raises(BadInput, match="2 of 10 frames"):
        mapped([Unusable(0, "torn"), Unusable(1, "torn"), perceived(2)], max_bad=0.1)
