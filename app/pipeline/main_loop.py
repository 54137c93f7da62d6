"""The main loop: every frame of a sequence goes through the method, and onto the timeline."""

from __future__ import annotations

from collections.abc import Iterable

from app.frames.frame_accounting import FrameAccounting
from app.frames.frame_packet import END, NOTHING_LEFT, FramePacket
from app.profiling.recorder import Recorder
from app.timeline.no_timeline import NoTimeline
from app.timeline.rerun_timeline import Timeline
from razer.mapper import Mapper
from razer.stages import stage


def map_frames(
    looks: Iterable[FramePacket],
    mapper: Mapper,
    timeline: Timeline | NoTimeline,
    recorder: Recorder,
    outcome: FrameAccounting,
) -> None:
    """Fuse what was seen of each frame; unusable and lost ones are counted in `outcome` and shown. A frame that was
    lost in its turn is fused when it comes late.

    Raises BadInput when `outcome` has had enough of unusable frames.
    """
    for look in looks:
        if look.corrections:
            mapper.move(look.corrections)
            outcome.move(look.corrections)
        if look.index == END:
            timeline.track(look)
            outcome.graph = None if look.report is None else look.report.graph
            continue
        if look.index == NOTHING_LEFT:
            return
        with recorder.frame(look.stage_ms):
            if not look.late:  # the timeline has passed it
                with stage("log"):
                    timeline.track(look)
            if look.seen is not None:
                step = mapper.fuse(look.seen)
                outcome.use(look.seen.frame)
                if look.late:
                    continue
                with stage("log"):
                    timeline.show(look.seen.frame, step, mapper, look.stage_ms)
                continue
            timeline.skipped(look.index, look.reason)
            if look.lost:
                outcome.lost.add(look.index)
            else:
                outcome.skip(look.index, look.reason)
