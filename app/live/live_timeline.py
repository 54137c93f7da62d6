"""The timeline of a run that is served: it is shown to both, the recording and whoever looks on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from app.live.publisher import Publisher
from app.timeline.null_timeline import NullTimeline
from razer.arrays import Pose
from razer.frame import Frame
from razer.mapper import Mapper
from razer.panoptic_map import PanopticMap
from razer.tracking.step_result import StepResult
from slam.report import PoseReport

if TYPE_CHECKING:
    from app.timeline.rerun_timeline import Timeline


class LiveTimeline(NullTimeline):
    """Hands everything on to a timeline, and frames to a publisher, too."""

    def __init__(self, timeline: Timeline | NullTimeline, publisher: Publisher) -> None:
        self._timeline, self._publisher = timeline, publisher

    def show(self, frame: Frame, step: StepResult, mapper: Mapper, stage_ms: Mapping[str, float]) -> None:
        """Show one mapped frame."""
        self._timeline.show(frame, step, mapper, stage_ms)
        self._publisher.show(frame, step, mapper)

    def track(
        self,
        frame_index: int,
        report: PoseReport | None,
        *,
        corrections: Mapping[int, Pose | None],
        given: Pose | None = None,
    ) -> None:
        """Show how a frame was located."""
        self._timeline.track(frame_index, report, corrections=corrections, given=given)

    def finish_tracking(self, report: PoseReport | None, corrections: Mapping[int, Pose | None]) -> None:
        """Show the last corrections."""
        self._timeline.finish_tracking(report, corrections)

    def skipped(self, frame_index: int, reason: str) -> None:
        """Show that a frame was not used, and why."""
        self._timeline.skipped(frame_index, reason)

    def finish(self, panoptic: PanopticMap) -> None:
        """Show the finished map."""
        self._timeline.finish(panoptic)

    def close(self, *, join: bool = True, keep_parts: bool = False) -> None:
        """Write out what is still pending."""
        self._timeline.close(join=join, keep_parts=keep_parts)
