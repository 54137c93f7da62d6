"""Pose lookup or estimation, the first process of a run: frames are read and located."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from time import perf_counter
from typing import NamedTuple

from app.frames.frame_packet import (
    AfterLastFrame,
    Located,
    LocatedPacket,
    Lost,
    NothingRecovered,
    PosesFinal,
    PoseUpdate,
    Request,
    SaveState,
    StateSaved,
    Unusable,
)
from app.frames.second_attempt import SecondAttempt
from app.profiling.stage_timer import time_stages
from app.stored_state.pose_checkpoints import PoseCheckpoints
from data_tools.recordings.color_warp import ColorWarp
from data_tools.recordings.sequence import RgbdSequence
from razer.arrays import Pose
from razer.errors import UnusableFrame
from razer.frame import Frame
from razer.stages import stage
from slam.poses import Poses


class _State(NamedTuple):
    """What the locator remembers: frames lost in their turn, poses of those that became known since, and the source of
    poses."""

    lost: set[int]
    recovered: dict[int, Pose]
    poses: Poses


@dataclass
class Locator:
    """Reads and locates frames; to be called in the order of the frames, from one thread. The source of poses is made
    where it is used, since it cannot travel to another process."""

    sequence: RgbdSequence
    make_poses: Callable[[], Poses]
    color_warp: ColorWarp | None = None  # poses are estimated from colour as it was recorded
    checkpoints: PoseCheckpoints | None = None
    second_attempt: SecondAttempt | None = None  # where too many frames are lost in the end

    @cached_property
    def _state(self) -> _State:
        """Made where it is used, or gone on from."""
        saved = None if self.checkpoints is None else self.checkpoints.load()
        return _State(set(), {}, self.make_poses()) if saved is None else _State(*saved)

    @property
    def poses(self) -> Poses:
        """The source of poses."""
        return self._state.poses

    def __call__(self, request: Request) -> LocatedPacket | NothingRecovered:
        """The posed frame of an index, or why there is none; after the last frame, what is asked for then; or what
        holds its state now."""
        match request:
            case AfterLastFrame.FINISH_POSES:
                return self._finish()
            case AfterLastFrame.NEXT_RECOVERED:
                return self._next_recovered()
            case SaveState(n_frames):
                return self._save(n_frames)
            case int(index):
                return self._locate(index)

    def _save(self, n_frames: int) -> StateSaved:
        assert self.checkpoints is not None
        start_s, state = perf_counter(), self._state
        try:
            saved = self.checkpoints.save((state.lost, state.recovered, state.poses))
        except OSError as error:
            return StateSaved(n_frames, None, perf_counter() - start_s, error.strerror or str(error))
        return StateSaved(n_frames, saved, perf_counter() - start_s)

    def _locate(self, index: int) -> LocatedPacket:
        pose_update = PoseUpdate()
        with time_stages() as stage_ms:
            try:
                with stage("decode"):
                    frame = self.sequence[index]
                with stage("pose"):
                    pose = self._state.poses.locate(frame)
                    pose_update = self._pose_update(frame.world_from_camera)
                if pose is not None:
                    return Located(self._registered(frame).at(pose), pose_update=pose_update, stage_ms=stage_ms)
            except UnusableFrame as error:
                return Unusable(index, str(error), pose_update=pose_update, stage_ms=stage_ms)
        self._state.lost.add(index)
        return Lost(index, pose_update=pose_update, stage_ms=stage_ms)

    def _pose_update(self, given: Pose | None = None) -> PoseUpdate:
        state = self._state
        corrections = state.poses.corrections()
        for index, pose in corrections.items():
            if pose is None:  # its turn, if it comes at all, comes after this
                state.lost.add(index)
                state.recovered.pop(index, None)
            elif index in state.lost:
                state.recovered[index] = pose
        return PoseUpdate(corrections, given, state.poses.report())

    def _finish(self) -> PosesFinal:
        """The last corrections, or all poses anew, where another attempt locates more frames."""
        attempt, state = self.second_attempt, self._state
        unmapped = set(state.lost)  # so far; what is lost from here on is in the map
        state.poses.finish()
        update = self._pose_update()
        again = None if attempt is None else attempt(len(state.lost - state.recovered.keys()))
        if again is None:
            return PosesFinal(update)
        solved, poses, note = again
        state.recovered.clear()
        state.recovered.update({i: pose for i, pose in poses.items() if i in unmapped and pose is not None})
        return PosesFinal(PoseUpdate(poses, report=solved.report()), note)

    def _next_recovered(self) -> Located | NothingRecovered:
        recovered = self._state.recovered
        if not recovered:
            return NothingRecovered()
        index = min(recovered)
        with time_stages() as stage_ms:
            with stage("decode"):
                frame = self.sequence[index].at(recovered.pop(index))
            frame = self._registered(frame)
        return Located(frame, stage_ms=stage_ms, is_late=True)

    def _registered(self, frame: Frame) -> Frame:
        if self.color_warp is None:
            return frame
        with stage("register"):
            return self.color_warp.registered(frame)
