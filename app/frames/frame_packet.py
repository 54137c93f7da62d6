"""Messages between the processes of a run: frames on their way from the recording to the map, one type for each state.

The locator answers each request with a `LocatedPacket` or `NothingRecovered`, the perceiver turns that into a
`FramePacket`, and the main loop matches on it. All of them travel by pickle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from enum import Enum, auto

from app.stored_state.saved_state import SavedState
from razer.arrays import Pose
from razer.detection.perception import Observation
from razer.frame import Frame
from slam.report import GraphReport, PoseReport


class AfterLastFrame(Enum):
    """What the locator is asked for once it was asked for every frame: to finish the poses, then, as often as there is
    one, for a frame whose pose became known only after its turn."""

    FINISH_POSES = auto()
    NEXT_RECOVERED = auto()


@dataclass(frozen=True, slots=True)
class SaveState:
    """The request to save what the locator holds, after `n_frames` of those asked for."""

    n_frames: int


Request = int | AfterLastFrame | SaveState  # the index of a frame, what comes after the last one, or a checkpoint


@dataclass(frozen=True, slots=True)
class PoseUpdate:
    """What the source of poses said with a frame: `corrections`, new world_from_camera (4, 4) of frames before it, by
    frame index, None where one is not known after all; `given`, the pose that the frame itself came with; `report`,
    what the estimation did, None where poses are given."""

    corrections: Mapping[int, Pose | None] = field(default_factory=dict)
    given: Pose | None = None
    report: PoseReport | None = None

    @property
    def graph(self) -> GraphReport | None:
        """The pose graph, if it was optimised with this frame."""
        return None if self.report is None else self.report.graph


@dataclass(frozen=True, slots=True)
class Located:
    """A posed frame, not yet perceived; `is_late` if it was lost in its turn. `stage_ms`: milliseconds by stage."""

    frame: Frame
    _: KW_ONLY
    pose_update: PoseUpdate = field(default_factory=PoseUpdate)
    stage_ms: Mapping[str, float] = field(default_factory=dict)
    is_late: bool = False

    @property
    def index(self) -> int:
        """The index of the frame."""
        return self.frame.index


@dataclass(frozen=True, slots=True)
class Perceived:
    """What a posed frame shows, ready to be mapped; the rest as in `Located`."""

    observation: Observation
    _: KW_ONLY
    pose_update: PoseUpdate = field(default_factory=PoseUpdate)
    stage_ms: Mapping[str, float] = field(default_factory=dict)
    is_late: bool = False

    @property
    def index(self) -> int:
        """The index of the frame."""
        return self.observation.frame.index


@dataclass(frozen=True, slots=True)
class Lost:
    """A frame whose camera could not be located in its turn; it may come late."""

    index: int
    _: KW_ONLY
    pose_update: PoseUpdate = field(default_factory=PoseUpdate)
    stage_ms: Mapping[str, float] = field(default_factory=dict)

    @property
    def reason(self) -> str:
        """Why it is not mapped, in one plain line."""
        return "lost: the camera could not be located"


@dataclass(frozen=True, slots=True)
class Unusable:
    """A frame that cannot be mapped, and why in one plain line; `is_late` if it was lost in its turn."""

    index: int
    reason: str
    _: KW_ONLY
    pose_update: PoseUpdate = field(default_factory=PoseUpdate)
    stage_ms: Mapping[str, float] = field(default_factory=dict)
    is_late: bool = False


@dataclass(frozen=True, slots=True)
class PosesFinal:
    """The answer to FINISH_POSES: the last corrections, and the finished pose graph; `note` says in one line if poses
    were estimated in another way in the end."""

    pose_update: PoseUpdate
    note: str = ""


@dataclass(frozen=True, slots=True)
class StateSaved:
    """The answer to SaveState: what holds the locator's state after `n_frames`, None where it could not be written, for
    the `reason`; and the seconds that it took."""

    n_frames: int
    poses: SavedState | None
    cost_s: float
    reason: str = ""


@dataclass(frozen=True, slots=True)
class NothingRecovered:
    """The answer to NEXT_RECOVERED when no frame is left that came to be known late."""


LocatedPacket = Located | Lost | Unusable | PosesFinal | StateSaved
FramePacket = Perceived | Lost | Unusable | PosesFinal
