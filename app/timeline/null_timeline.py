"""The null object of the timeline, so that the main loop need not ask whether there is one."""

from __future__ import annotations

from collections.abc import Mapping

from razer.arrays import Pose
from razer.frame import Frame
from razer.mapper import Mapper
from razer.panoptic_map import PanopticMap
from razer.tracking.step_result import StepResult
from slam.report import PoseReport


class NullTimeline:
    """A `Timeline` that ignores whatever is logged."""

    def show(self, frame: Frame, step: StepResult, mapper: Mapper, stage_ms: Mapping[str, float]) -> None:
        """Nothing."""

    def track(
        self,
        frame_index: int,
        report: PoseReport | None,
        *,
        corrections: Mapping[int, Pose | None],
        given: Pose | None = None,
    ) -> None:
        """Nothing."""

    def finish_tracking(self, report: PoseReport | None, corrections: Mapping[int, Pose | None]) -> None:
        """Nothing."""

    def skipped(self, frame_index: int, reason: str) -> None:
        """Nothing."""

    def finish(self, panoptic: PanopticMap) -> None:
        """Nothing."""

    def close(self, *, join: bool = True, keep_parts: bool = False) -> None:
        """Nothing."""
