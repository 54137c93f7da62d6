"""Accounts of a run and of tracking over one recording, whatever the poses say and when: equal, and equal to what a
slow list of the final poses says."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console

from app.frames.frame_accounting import FrameAccounting
from app.frames.frame_packet import AfterLastFrame, FramePacket, Located, NothingRecovered
from app.frames.locator import Locator
from app.frames.perceiver import Perceiver
from app.frames.selection import selected_frames
from app.pipeline import track_only
from app.pipeline.main_loop import map_frames
from app.profiling.recorder import Recorder
from app.settings.run_config import InputSettings, RunConfig
from data_tools.recordings.trajectories import tum_text
from razer.arrays import Pose
from razer.detection.perception import Observation
from razer.errors import BadInput, UnusableFrame
from razer.frame import Frame, Intrinsics
from slam.report import PoseReport

CAMERA = Intrinsics(4, 3, 5.0, 5.0, 1.5, 1.0)
N_FRAMES = 14


@dataclass(frozen=True)
class Plan:
    """Which frames are torn, located in their turn, and in the world in the end; `wavering`: by frame, the turns at
    which its pose comes to be known, or is lost again."""

    torn: set[int]
    located: set[int]
    world: set[int]
    wavering: dict[int, list[int]]


indices = st.integers(0, N_FRAMES - 1)
plans = st.builds(
    Plan, st.sets(indices, max_size=4), st.sets(indices), st.sets(indices), st.dictionaries(indices, st.lists(indices))
)
ranges = st.builds(
    InputSettings,
    start=st.integers(0, 5),
    end=st.none() | st.integers(6, 20),
    stride=st.integers(1, 3),
    max_frames=st.none() | st.integers(1, 10),
)


@dataclass(frozen=True)
class Clip:
    """Frames of which the torn ones cannot be read."""

    torn: set[int]
    name: str = "clip"
    intrinsics: Intrinsics = CAMERA
    has_poses: bool = False
    depth_scale: float = 1.0

    def __len__(self) -> int:
        return N_FRAMES

    def __getitem__(self, index: int) -> Frame:
        if index in self.torn:
            raise UnusableFrame(f"frame {index} is torn")
        return Frame(index, index / 30, np.zeros((3, 4, 3), np.uint8), np.zeros((3, 4), np.float32), CAMERA)


@dataclass
class Wavering:
    """A source of poses that goes by a plan, and corrects itself as `SlamSystem` does."""

    plan: Plan
    reported: dict[int, Pose | None] = field(default_factory=dict)
    turn: int = -1
    keyframes: tuple[()] = ()
    n_loops: int = 0
    _is_finished: bool = False

    def locate(self, frame: Frame) -> Pose | None:
        self.turn = frame.index
        self.reported[frame.index] = np.eye(4) if frame.index in self.plan.located else None
        return self.reported[frame.index]

    def trajectory(self) -> dict[int, Pose]:
        seen = set(self.reported)
        return {index: np.eye(4) for index in sorted(seen & self.plan.world)}

    def corrections(self) -> dict[int, Pose | None]:
        known = set(self.trajectory()) if self._is_finished else self._known_now()
        differ = [index for index, pose in self.reported.items() if (pose is not None) != (index in known)]
        changed = {index: np.eye(4) if index in known else None for index in differ}
        self.reported |= changed
        return changed

    def _known_now(self) -> set[int]:
        """Those that were located, changing their state at each turn of theirs that has come."""
        return {
            i
            for i in self.reported
            if ((i in self.plan.located) + sum(i < turn <= self.turn for turn in self.plan.wavering.get(i, ()))) % 2
        }

    def finish(self) -> None:
        self._is_finished = True

    def report(self) -> PoseReport:
        return PoseReport(None, None, None)


class Nothing:
    def observe(self, frame: Frame) -> Observation:
        return Observation(frame, None, None)  # type: ignore[arg-type]


class Silent:
    """A mapper and a timeline that do nothing."""

    def __getattr__(self, name: str) -> Any:
        return lambda *arguments, **named: None


def packets_of(plan: Plan, chosen: range) -> list[FramePacket]:
    locator, perceiver = Locator(Clip(plan.torn), lambda: Wavering(plan)), Perceiver(Nothing())  # type: ignore
    packets = [perceiver(locator(index)) for index in chosen]
    packets.append(perceiver(locator(AfterLastFrame.FINISH_POSES)))
    while not isinstance(answer := locator(AfterLastFrame.NEXT_RECOVERED), NothingRecovered):
        assert isinstance(answer, Located)
        packets.append(perceiver(answer))
    return packets


def mapped(packets: list[FramePacket], n_asked: int) -> tuple[FrameAccounting, Recorder]:
    accounting, recorder = FrameAccounting("clip", n_asked, 1.0), Recorder(n_asked, lambda: 0)
    map_frames(packets, Silent(), Silent(), recorder, accounting)
    return accounting, recorder


def check_against_slow_reference(accounting: FrameAccounting, came: list[int], used: list[int], torn: set[int]) -> None:
    account = accounting.account()
    skipped = [index for index in came if index in torn]
    lost = [index for index in came if index not in torn and index not in used]
    assert accounting.indices == used
    assert (account.frames, account.used, account.lost) == (len(came), len(used), len(lost))
    assert [one.frame for one in account.skipped or ()] == skipped
    covered = [[i for i in lost if first <= i <= last] for first, last in account.lost_intervals or ()]
    assert [index for interval in covered for index in interval] == lost
    for interval in covered:
        assert not any(interval[0] < index < interval[-1] for index in used)


@settings(max_examples=150, deadline=None)
@given(plan=plans, chosen=ranges)
def test_a_run_and_tracking_give_the_account_of_the_final_poses(plan: Plan, chosen: InputSettings) -> None:
    asked = selected_frames(Clip(plan.torn), chosen)  # type: ignore[arg-type]
    accounting, recorder = mapped(packets_of(plan, asked), len(asked))
    used = [index for index in asked if index in plan.world - plan.torn]
    check_against_slow_reference(accounting, list(asked), used, plan.torn)
    account = accounting.account()
    assert account.tracked == len(used) / len(asked)
    assert recorder.timings()["frames"] == account.frames == len(asked)
    assert len(tum_text(accounting.stamps, accounting.poses).splitlines()) == 1 + account.used
    config = RunConfig(input=chosen.model_copy(update={"sparse": False}))  # no second attempt by other means
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(track_only, "SlamSystem", lambda _: Wavering(plan))
        if not used:
            with pytest.raises(BadInput, match="could not be located in any frame"):
                track_only.tracked_path(Clip(plan.torn), config, Console(quiet=True))  # type: ignore[arg-type]
            return
        tracked = track_only.tracked_path(Clip(plan.torn), config, Console(quiet=True))  # type: ignore[arg-type]
    assert tracked.account() == account
    assert list(tracked.final) == used


@settings(max_examples=50, deadline=None)
@given(plan=plans, n_done=st.integers(0, N_FRAMES))
def test_a_run_that_is_cut_short_counts_what_came(plan: Plan, n_done: int) -> None:
    packets = packets_of(plan, range(N_FRAMES))[:n_done]
    accounting, recorder = mapped(packets, N_FRAMES)
    used = list(accounting.indices)
    check_against_slow_reference(accounting, list(range(n_done)), used, plan.torn)
    account = accounting.account()
    assert account.tracked == len(used) / N_FRAMES
    assert recorder.timings()["frames"] == account.frames == n_done
