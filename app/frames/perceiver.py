"""Second process of a run: what located frames show."""

from __future__ import annotations

from dataclasses import dataclass, replace

from app.frames.frame_packet import FramePacket
from app.profiling.recorder import timed
from razer.detection.perception import Perception
from razer.errors import UnusableFrame


@dataclass(frozen=True)
class Perceiver:
    """Perceives located frames, which are not handed on."""

    perception: Perception

    def __call__(self, look: FramePacket) -> FramePacket:
        """The look with what its frame shows, or the reason why that cannot be used; one without a frame as it is."""
        if look.frame is None:
            return look
        with timed(look.stage_ms):
            try:
                return replace(look, frame=None, seen=self.perception.observe(look.frame))
            except UnusableFrame as error:
                return replace(look, frame=None, reason=str(error))
