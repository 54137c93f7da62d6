"""Mapping of a sequence: frames come from helper processes and go through the main loop; then the map is finished."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from typing import TYPE_CHECKING

from rich.console import Console

from app.checkpoints.ongoing_run import OngoingRun
from app.checkpoints.run_checkpoints import RunCheckpoints
from app.console.progress import show_progress
from app.console.streams import print_warnings
from app.console.waiting import waiting_for
from app.frames.frame_packet import FramePacket, StateSaved
from app.frames.helper_wait import HelperWait
from app.frames.packet_stream import packet_stream
from app.frames.prefetch_process import HelperEnded, prefetch
from app.frames.selection import selected_frames
from app.pipeline.interrupt import FAILED, StopRequest, until_interrupted
from app.pipeline.main_loop import map_frames
from app.pipeline.prepare_run import poses_of, second_attempt
from app.profiling.memory import rss_mb
from app.profiling.recorder import Recorder
from app.settings.run_config import RunConfig
from app.timeline.null_timeline import NullTimeline
from data_tools.recordings.sequence import RgbdSequence
from razer.mapper import Mapper
from razer.panoptic_map import PanopticMap
from slam.poses import Poses

if TYPE_CHECKING:
    from app.timeline.rerun_timeline import Timeline
    from slam.sparse.solved_poses import SolvedPoses


def map_sequence(
    sequence: RgbdSequence,
    config: RunConfig,
    run: OngoingRun,
    console: Console,
    *,
    shown: Timeline | NullTimeline | None = None,
    checkpoints: RunCheckpoints | None = None,
    stop: StopRequest | None = None,
    solved: SolvedPoses | None = None,
) -> PanopticMap:
    """Run the main loop with progress shown, and finish the map; a stop that is requested ends it early, and
    `interrupted` of the account says so.

    Args:
        sequence: the recording.
        config: the settings, with the choice of poses made.
        run: what takes in the frames.
        console: where progress is shown.
        shown: the timeline that sees the frames, if another one than the run's.
        checkpoints: writes them now and then.
        stop: whether to end early.
        solved: poses of all frames, where they are known beforehand.

    Raises:
        BadInput: where too many frames cannot be used, or none was located.
    """
    stop = StopRequest() if stop is None else stop
    accounting, timeline = run.accounting, run.timeline if shown is None else shown
    make_poses = poses_of(config, solved)
    with _frames(sequence, config, run, console, checkpoints, stop, make_poses) as frames:
        try:
            map_frames(frames, run.mapper, timeline, run.recorder, accounting)
        except HelperEnded as error:
            print_warnings([f"{error}; what was mapped until then is saved"])
            accounting.interrupted, stop.exit_code = True, FAILED
        accounting.interrupted |= stop.requested
    accounting.require_used()
    if not accounting.used:
        raise KeyboardInterrupt  # stopped before the first frame: there is nothing to keep
    with waiting_for("mapping the kept frames once more at their final poses", console):
        caught_up = _catch_up(run.mapper, run.recorder, stop)
    with waiting_for("finishing the map", console):
        return run.mapper.finish(catch_up=caught_up)


@contextmanager
def _frames(
    sequence: RgbdSequence,
    config: RunConfig,
    run: OngoingRun,
    console: Console,
    checkpoints: RunCheckpoints | None,
    stop: StopRequest,
    make_poses: Callable[[], Poses],
) -> Iterator[Iterator[FramePacket]]:
    """The packets of all frames that are left, with progress shown and checkpoints written, until a stop."""
    indices, n_before = selected_frames(sequence, config.input), 0
    from_checkpoints = None if checkpoints is None else checkpoints.stream
    if from_checkpoints is not None and (n_before := from_checkpoints.n_before):
        console.print(f"resumed after {n_before} of {len(indices)} frames")

    def status() -> str:
        confirmed = sum(track.confirmed for track in run.mapper.tracks)
        return f"{run.recorder.frames_per_s:.1f} frames/s, {confirmed} instances, {rss_mb():.0f} MB"

    perception, warp, waiting = run.mapper.perception, run.registration.warp, HelperWait(stop, console)
    left, again = indices[n_before:], second_attempt(sequence, config)
    with packet_stream(sequence, left, make_poses, perception, warp, from_checkpoints, waiting, again) as packets:
        if checkpoints is None:
            frames = (packet for packet in packets if not isinstance(packet, StateSaved))
        else:
            frames = checkpoints.saving(packets, run)
        first = "starting the 2D models and the first frame"
        yield show_progress(until_interrupted(frames, stop), len(indices), status, console, first=first, done=n_before)


def _catch_up(mapper: Mapper, recorder: Recorder, stop: StopRequest) -> bool:
    """Reintegrate all kept frames at their final poses; whether there was time to."""
    was_requested = stop.requested
    with closing(mapper.catch_up(prefetch)) as steps:
        for _ in recorder.afterwards(steps):
            if stop.requested and not was_requested:
                return False
    return True
