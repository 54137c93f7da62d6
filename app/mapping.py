"""The main loop: every frame of a sequence goes through the method, and onto the timeline."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from app.no_timeline import NoTimeline
from app.outcome import Outcome
from app.prefetch import Decoded
from app.recorder import Recorder
from app.timeline import Timeline
from razer.frame import UnusableFrame
from razer.mapper import Mapper
from razer.stages import stage
from slam.system import Poses

Watch = Callable[[Iterable[Decoded]], Iterable[Decoded]]


def map_frames(
    frames: Iterable[Decoded],
    poses: Poses,
    mapper: Mapper,
    timeline: Timeline | NoTimeline,
    recorder: Recorder,
    outcome: Outcome,
) -> None:
    """Feed decoded frames to the mapper; unusable and lost ones are counted in `outcome` and shown.

    Raises BadInput when `outcome` has had enough of unusable frames.
    """
    for decoded in frames:
        with recorder.frame(decoded.decode_ms) as stage_ms:
            try:
                _map_frame(decoded, poses, mapper, timeline, stage_ms, outcome)
            except UnusableFrame as error:
                outcome.skip(decoded.index, str(error))
                timeline.skipped(decoded.index, str(error))


def _map_frame(
    decoded: Decoded,
    poses: Poses,
    mapper: Mapper,
    timeline: Timeline | NoTimeline,
    stage_ms: dict[str, float],
    outcome: Outcome,
) -> None:
    if decoded.frame is None:
        raise UnusableFrame(decoded.reason)
    with stage("pose"):
        pose = poses.locate(decoded.frame)
    if pose is None:
        outcome.lost += 1
        timeline.skipped(decoded.index, "lost: the camera could not be located")
        return
    frame = decoded.frame.at(pose)
    step = mapper.step(frame)
    outcome.use(frame)
    with stage("log"):
        timeline.show(frame, step, mapper, stage_ms)
