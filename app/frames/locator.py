"""Pose lookup or estimation, the first process of a run: frames are read and located."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

from app.frames.frame_packet import (
    AfterLastFrame,
    Located,
    LocatedPacket,
    Lost,
    NothingRecovered,
    PosesFinal,
    PoseUpdate,
    Request,
    Unusable,
)
from app.profiling.stage_timer import time_stages
from data_tools.recordings.color_warp import ColorWarp
from data_tools.recordings.sequence import RgbdSequence
from razer.arrays import Pose
from razer.errors import UnusableFrame
from razer.frame import Frame
from razer.stages import stage
from slam.poses import Poses


@dataclass
class Locator:
    """Reads and locates frames; to be called in the order of the frames, from one thread. The source of poses is made
    where it is used, since it cannot travel to another process."""

    sequence: RgbdSequence
    make_poses: Callable[[], Poses]
    color_warp: ColorWarp | None = None  # poses are estimated from colour as it was recorded
    _lost: set[int] = field(default_factory=set)
    _recovered: dict[int, Pose] = field(default_factory=dict)

    @cached_property
    def poses(self) -> Poses:
        """The source of poses."""
        return self.make_poses()

    def __call__(self, request: Request) -> LocatedPacket | NothingRecovered:
        """The posed frame of an index, or why there is none; after the last frame, what is asked for then."""
        match request:
            case AfterLastFrame.FINISH_POSES:
                self.poses.finish()
                return PosesFinal(self._pose_update())
            case AfterLastFrame.NEXT_RECOVERED:
                return self._next_recovered()
            case int(index):
                return self._locate(index)

    def _locate(self, index: int) -> LocatedPacket:
        pose_update = PoseUpdate()
        with time_stages() as stage_ms:
            try:
                with stage("decode"):
                    frame = self.sequence[index]
                with stage("pose"):
                    pose = self.poses.locate(frame)
                    pose_update = self._pose_update(frame.world_from_camera)
                if pose is not None:
                    return Located(self._registered(frame).at(pose), pose_update=pose_update, stage_ms=stage_ms)
            except UnusableFrame as error:
                return Unusable(index, str(error), pose_update=pose_update, stage_ms=stage_ms)
        self._lost.add(index)
        return Lost(index, pose_update=pose_update, stage_ms=stage_ms)

    def _pose_update(self, given: Pose | None = None) -> PoseUpdate:
        corrections = self.poses.corrections()
        for index, pose in corrections.items():
            if pose is None:  # its turn, if it comes at all, comes after this
                self._lost.add(index)
                self._recovered.pop(index, None)
            elif index in self._lost:
                self._recovered[index] = pose
        return PoseUpdate(corrections, given, self.poses.report())

    def _next_recovered(self) -> Located | NothingRecovered:
        if not self._recovered:
            return NothingRecovered()
        index = min(self._recovered)
        with time_stages() as stage_ms:
            with stage("decode"):
                frame = self.sequence[index].at(self._recovered.pop(index))
            frame = self._registered(frame)
        return Located(frame, stage_ms=stage_ms, is_late=True)

    def _registered(self, frame: Frame) -> Frame:
        if self.color_warp is None:
            return frame
        with stage("register"):
            return self.color_warp.registered(frame)
