"""One frame on its way to the map: read, located and perceived, each in a process of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from razer.detection.perception import Observation
from razer.frame import Frame
from slam.poses import Pose
from slam.report import PoseReport

END = -1  # the index that comes after all frames
LATE = -2  # and the one that asks, after that, for a frame whose pose became known too late
NOTHING_LEFT = -3  # the index of the answer when there is none


@dataclass(slots=True)
class FramePacket:
    """What is known of one index: the posed frame until it is perceived, then what was seen, or why nothing was;
    corrections are new poses of frames before it, by frame index, None where one is not known after all; given, the
    pose that the frame itself came with; late, whether the frame was lost when its turn came; report, what the pose
    estimation did, if there is one; stage_ms holds milliseconds per stage."""

    index: int
    frame: Frame | None = None
    seen: Observation | None = None
    lost: bool = False
    late: bool = False
    reason: str = ""
    corrections: Mapping[int, Pose | None] = field(default_factory=dict)
    given: Pose | None = None
    report: PoseReport | None = None
    stage_ms: dict[str, float] = field(default_factory=dict)
