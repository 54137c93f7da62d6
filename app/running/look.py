"""One frame read, located and perceived: what can be done before the map is asked, and so on another thread."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from app.running.recorder import timed
from data_tools.sequence import Sequence
from razer.frame import UnusableFrame
from razer.perception import Observation, Perception
from razer.stages import stage
from slam.poses import Pose, Poses
from slam.report import PoseReport

END = -1  # the index that comes after all frames
LATE = -2  # and the one that asks, after that, for a frame whose pose became known too late
NOTHING_LEFT = -3  # the index of the answer when there is none


@dataclass(slots=True)
class Look:
    """What was seen at one index, or why nothing was; corrections are new poses of frames before it, by frame index;
    given, the pose that the frame itself came with; late, whether the frame was lost when its turn came; report, what
    the pose estimation did, if there is one; stage_ms holds milliseconds per stage."""

    index: int
    seen: Observation | None = None
    lost: bool = False
    late: bool = False
    reason: str = ""
    corrections: Mapping[int, Pose] = field(default_factory=dict)
    given: Pose | None = None
    report: PoseReport | None = None
    stage_ms: dict[str, float] = field(default_factory=dict)


@dataclass
class Looker:
    """Reads, locates and perceives frames; to be called in the order of the frames, from one thread. The source of
    poses is made where it is used, since it cannot travel to another process."""

    sequence: Sequence
    make_poses: Callable[[], Poses]
    perception: Perception
    _lost: set[int] = field(default_factory=set)
    _late: dict[int, Pose] = field(default_factory=dict)

    @cached_property
    def poses(self) -> Poses:
        """The source of poses."""
        return self.make_poses()

    def __call__(self, index: int) -> Look:
        """Look at one frame; a frame that cannot be used gives the reason and no observation. At END the poses are
        finished, and their last corrections told; at each LATE after that, one of the frames is seen that were lost in
        their turn and are known by now."""
        if index == LATE:
            return self._seen_late()
        look = Look(index)
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

    def _fill(self, look: Look) -> None:
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
            look.seen = self.perception.observe(frame.at(pose))

    def _take_corrections(self, look: Look) -> None:
        look.corrections, look.report = self.poses.corrections(), self.poses.report()
        self._late.update({index: pose for index, pose in look.corrections.items() if index in self._lost})

    def _seen_late(self) -> Look:
        if not self._late:
            return Look(NOTHING_LEFT)
        index = min(self._late)
        look = Look(index, late=True)
        with timed(look.stage_ms):
            look.seen = self.perception.observe(self.sequence[index].at(self._late.pop(index)))
        return look
