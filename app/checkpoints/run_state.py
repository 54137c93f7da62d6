"""State of the process that maps: the mapper, what became of the frames, their figures, and the timeline."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from app.checkpoints.map_state import known_map
from app.frames.cameras.color_registration import ColorRegistration
from app.frames.frame_account import SkippedFrame
from app.frames.frame_accounting import FrameAccounting
from app.stored_state.state_codec import KnownObjects
from app.timeline.null_timeline import NullTimeline
from data_tools.calibration.rgbd_estimate import RgbdEstimate
from data_tools.recordings.rgbd_calibration import RgbdCalibration
from razer.config import MapperConfig
from razer.frame import Intrinsics
from razer.mapper import MapperState

if TYPE_CHECKING:
    from app.timeline.rerun_timeline import Timeline

CLASSES = (ColorRegistration, FrameAccounting, Intrinsics, RgbdCalibration, RgbdEstimate, SkippedFrame)


@dataclass(frozen=True)
class RunState:
    """`recorder` and `timeline` are what those give as their state, the latter None where there is none; `resumed_at`,
    the frames after which the run went on from a checkpoint."""

    mapper: MapperState
    accounting: FrameAccounting
    recorder: dict[str, Any]
    registration: ColorRegistration
    timeline: dict[str, Any] | None
    resumed_at: tuple[int, ...]


def known_run(config: MapperConfig, timeline: Timeline | NullTimeline) -> KnownObjects:
    """What a `RunState` may speak of: of a mapper with these settings, and with this timeline."""
    known = known_map(config) + KnownObjects.of((RunState, *CLASSES))
    if isinstance(timeline, NullTimeline):
        return known
    from app.checkpoints.timeline_state import known_timeline

    return known + known_timeline(timeline)
