"""Segmentation, embedding and lifting, the second process of a run: what located frames show."""

from __future__ import annotations

from dataclasses import dataclass

from app.frames.frame_packet import FramePacket, Located, LocatedPacket, Perceived, StateSaved, Unusable
from app.profiling.stage_timer import time_stages
from razer.detection.perception import Perception
from razer.errors import UnusableFrame


@dataclass(frozen=True)
class Perceiver:
    """Perceives located frames and hands on everything else as it is."""

    perception: Perception

    def __call__(self, packet: LocatedPacket) -> FramePacket | StateSaved:
        """What a located frame shows, or the reason why that cannot be used."""
        if not isinstance(packet, Located):
            return packet
        update = packet.pose_update
        with time_stages(packet.stage_ms) as stage_ms:
            try:
                observation = self.perception.observe(packet.frame)
            except UnusableFrame as error:
                reason, is_late = str(error), packet.is_late
                return Unusable(packet.index, reason, pose_update=update, stage_ms=stage_ms, is_late=is_late)
        return Perceived(observation, pose_update=update, stage_ms=stage_ms, is_late=packet.is_late)
