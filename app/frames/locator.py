"""First process of a run: frames are read and located."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

from app.frames.frame_packet import END, LATE, NOTHING_LEFT, FramePacket
from app.profiling.recorder import timed
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import UnusableFrame
from razer.stages import stage
from slam.poses import Pose, Poses


@dataclass
class Locator:
    """Reads and locates frames; to be called in the order of the frames, from one thread. The source of poses is made
    where it is used, since it cannot travel to another process."""

    sequence: RgbdSequence
    make_poses: Callable[[], Poses]
    _lost: set[int] = field(default_factory=set)
    _late: dict[int, Pose] = field(default_factory=dict)

    @cached_property
    def poses(self) -> Poses:
        """The source of poses."""
        return self.make_poses()

    def __call__(self, index: int) -> FramePacket:
        """The posed frame of an index, or the reason why there is none. At END the poses are finished, and their last
        corrections told; at each LATE after that comes one of the frames that were lost in their turn and are known by
        now."""
        if index == LATE:
            return self._found_late()
        look = FramePacket(index)
        if index == END:
            self.poses.finish()
            self._take_corrections(look)
            return look
        with timed(look.stage_ms):
            try:
                self._fill(look)
            except UnusableFrame as error:
                look.reason = str(error)
        return look

    def _fill(self, look: FramePacket) -> None:
        with stage("decode"):
            frame = self.sequence[look.index]
        with stage("pose"):
            pose = self.poses.locate(frame)
            self._take_corrections(look)
        look.given = frame.world_from_camera
        if pose is None:
            self._lost.add(look.index)
            look.lost, look.reason = True, "lost: the camera could not be located"
        else:
            look.frame = frame.at(pose)

    def _take_corrections(self, look: FramePacket) -> None:
        look.corrections, look.report = self.poses.corrections(), self.poses.report()
        for index, pose in look.corrections.items():
            if index in self._lost and pose is not None:
                self._late[index] = pose

    def _found_late(self) -> FramePacket:
        if not self._late:
            return FramePacket(NOTHING_LEFT)
        index = min(self._late)
        look = FramePacket(index, late=True)
        with timed(look.stage_ms), stage("decode"):
            look.frame = self.sequence[index].at(self._late.pop(index))
        return look
