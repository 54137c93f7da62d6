"""A timeline that shows nothing, so that the loop needs no question whether there is one."""

from __future__ import annotations

from collections.abc import Mapping

from app.frames.frame_packet import FramePacket
from razer.frame import Frame
from razer.mapper import Mapper
from razer.panoptic_map import PanopticMap
from razer.tracking.step_result import StepResult


class NoTimeline:
    """Takes what `Timeline` takes and does nothing."""

    def show(self, frame: Frame, step: StepResult, mapper: Mapper, stage_ms: Mapping[str, float]) -> None:
        """Nothing."""

    def track(self, look: FramePacket) -> None:
        """Nothing."""

    def skipped(self, frame_index: int, reason: str) -> None:
        """Nothing."""

    def finish(self, mapper: Mapper, panoptic: PanopticMap) -> None:
        """Nothing."""

    def close(self) -> None:
        """Nothing."""
