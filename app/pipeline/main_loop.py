"""The main loop: every frame of a sequence goes through the method, and onto the timeline."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from app.frames.frame_accounting import FrameAccounting
from app.frames.frame_packet import FramePacket, Lost, Perceived, PosesFinal, Unusable
from app.frames.frame_weights import frame_weights
from app.profiling.recorder import Recorder
from app.timeline.null_timeline import NullTimeline
from razer.mapper import Mapper
from razer.stages import stage
from slam.report import GraphReport

if TYPE_CHECKING:  # Rerun takes 60 MB, which runs without a timeline never need
    from app.timeline.rerun_timeline import Timeline


def map_frames(
    packets: Iterable[FramePacket],
    mapper: Mapper,
    timeline: Timeline | NullTimeline,
    recorder: Recorder,
    accounting: FrameAccounting,
) -> None:
    """Map every usable frame, and let map and account follow corrected poses.

    Args:
        packets: the frames in order, then PosesFinal, then those that were lost in their turn and are known by now.
        mapper: the method.
        timeline: where it is shown.
        recorder: measures what each frame takes.
        accounting: counts what became of each frame.

    Raises:
        BadInput: when `accounting` has had enough of unusable frames.
    """
    for packet in packets:
        if corrections := packet.pose_update.corrections:
            mapper.move(corrections)
            accounting.correct(corrections)
        match packet:
            case Perceived(observation, is_late=False):
                with recorder.frame(packet.stage_ms) as stage_ms:
                    _show_tracking(packet, timeline)
                    step = mapper.fuse(observation)
                    accounting.use(observation.frame, packet.pose_update.given)
                    with stage("log"):
                        timeline.show(observation.frame, step, mapper, stage_ms)
            case Perceived(observation):  # the timeline has passed it
                with recorder.late_frame(packet.stage_ms):
                    mapper.fuse(observation)
                    accounting.use(observation.frame)
            case Lost(index):
                with recorder.frame(packet.stage_ms):
                    _show_tracking(packet, timeline)
                    timeline.skipped(index, packet.reason)
                    accounting.lost.add(index)
            case Unusable(index, reason, is_late=True):
                accounting.skip(index, reason)
            case Unusable(index, reason):
                with recorder.frame(packet.stage_ms):
                    _show_tracking(packet, timeline)
                    timeline.skipped(index, reason)
                    accounting.skip(index, reason)
            case PosesFinal(update, note):
                timeline.finish_tracking(update.report, update.corrections)
                _finish_poses(update.graph, note, mapper, accounting)


def _finish_poses(graph: GraphReport | None, note: str, mapper: Mapper, accounting: FrameAccounting) -> None:
    accounting.graph, accounting.pose_note = graph, note
    if graph is not None:
        frames = [*accounting.indices, *sorted(accounting.lost)]  # of which some are about to come late
        mapper.weigh(frame_weights(graph, frames, mapper.config.voxels.voxel_size_m))


def _show_tracking(packet: Perceived | Lost | Unusable, timeline: Timeline | NullTimeline) -> None:
    update = packet.pose_update
    with stage("log"):
        timeline.track(packet.index, update.report, corrections=update.corrections, given=update.given)
