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


@dataclass(slots=True)
class Look:
    """What was seen at one index, or why nothing was; corrections are new poses of frames before it, by frame index;
    given, the pose that the frame itself came with; report, what the pose estimation did, if there is one; stage_ms
    holds milliseconds per stage."""

    index: int
    seen: Observation | None = None
    lost: bool = False
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

    @cached_property
    def poses(self) -> Poses:
        """The source of poses."""
        return self.make_poses()

    def __call__(self, index: int) -> Look:
        """Look at one frame; a frame that cannot be used gives the reason and no observation. At END the poses are
        finished, and their last corrections told."""
        look = Look(index)
        if index == END:
            self.poses.finish()
            look.corrections, look.report = self.poses.corrections(), self.poses.report()
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
            look.corrections, look.report = self.poses.corrections(), self.poses.report()
        look.given = frame.world_from_camera
        if pose is None:
            look.lost, look.reason = True, "lost: the camera could not be located"
        else:
            look.seen = self.perception.observe(frame.at(pose))
