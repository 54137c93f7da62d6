"""One frame read, located and perceived: what can be done before the map is asked, and so on another thread."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.running.recorder import timed
from data_tools.sequence import Sequence
from razer.frame import UnusableFrame
from razer.perception import Observation, Perception
from razer.stages import stage
from slam.system import Poses


@dataclass(slots=True)
class Look:
    """What was seen at one index, or why nothing was; stage_ms holds milliseconds per stage."""

    index: int
    seen: Observation | None = None
    lost: bool = False
    reason: str = ""
    stage_ms: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Looker:
    """Reads, locates and perceives frames; to be called in the order of the frames, from one thread."""

    sequence: Sequence
    poses: Poses
    perception: Perception

    def __call__(self, index: int) -> Look:
        """Look at one frame; a frame that cannot be used gives the reason and no observation."""
        look = Look(index)
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
        if pose is None:
            look.lost, look.reason = True, "lost: the camera could not be located"
        else:
            look.seen = self.perception.observe(frame.at(pose))
