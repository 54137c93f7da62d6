"""The mapping pipeline: one run from an open sequence to a finished run folder."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rich.console import Console

from app.checkpoints.ongoing_run import OngoingRun
from app.checkpoints.run_checkpoints import RunCheckpoints, RunPlan
from app.console.no_room import NO_ROOM
from app.console.waiting import waiting_for
from app.frames.cameras.color_registration import ColorRegistration, register_color
from app.frames.frame_accounting import FrameAccounting
from app.frames.selection import selected_frames
from app.pipeline.interrupt import StopRequest
from app.pipeline.map_sequence import map_sequence
from app.pipeline.prepare_run import (
    begin_run,
    make_mapper,
    open_timeline,
    print_model_note,
    resolve_models,
    resolve_poses,
    solved_poses,
)
from app.pipeline.stored_masks import note_stored_masks
from app.pipeline.watchers import NOBODY, Watchers
from app.run_folder.run_folder import RunFolder
from app.run_folder.save_run import save_camera, save_config, save_registration, save_run, save_timings
from app.run_folder.world_frame import save_world
from app.settings.run_config import RunConfig
from app.stored_state.checkpoint import FILE
from app.stored_state.checkpoint import FOLDER as CHECKPOINT
from app.timeline.null_timeline import NullTimeline
from app.timeline.viewer.live_viewer import open_live
from data_tools.recordings.local_origin import origin_of
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import BadInput
from razer.panoptic_map import PanopticMap

if TYPE_CHECKING:
    from app.live.live_run import LiveRun
    from app.timeline.rerun_timeline import Timeline


@dataclass(frozen=True)
class RunResult:
    """What a run made: the account of its frames, the map, the contents of timings.json, and the settings with every
    choice made; `exit_code`, that of the verb: 0, or which way the run was ended early."""

    accounting: FrameAccounting
    panoptic: PanopticMap
    timings: dict[str, Any]
    registration: ColorRegistration
    config: RunConfig
    exit_code: int = 0


def run_to_folder(
    sequence: RgbdSequence,
    config: RunConfig,
    folder: RunFolder,
    console: Console,
    watchers: Watchers = NOBODY,
    *,
    is_reopenable: bool = False,
    vocabulary: str | None = None,
) -> RunResult:
    """Map `sequence` and leave everything in `folder`; if it fails nothing at all, or the checkpoint to resume it from.
    A Ctrl-C keeps what was mapped.

    Args:
        sequence: the recording.
        config: the settings.
        folder: where the run goes; it goes on from the checkpoint that this holds.
        console: where progress is shown.
        watchers: who sees the run while it goes on.
        is_reopenable: whether `input.folder` is the recording, so that the run can be resumed from checkpoints.
        vocabulary: what the instances are to be named by later; checkpoints remember it.

    Raises:
        BadInput: for input or settings that cannot be used, and where the folder cannot be written.
    """
    config, note = resolve_models(resolve_poses(config, sequence))
    with waiting_for("loading the 2D models", console):
        mapper = make_mapper(config)
    note_stored_masks(mapper.perception.segmenter, selected_frames(sequence, config.input), console)
    registration = _registration(sequence, config, folder, console)
    solved = None if folder.checkpoint is not None else solved_poses(sequence, config, console)
    print_model_note(note, console)  # after all that can be refused: who has to ask anew reads one line
    with _told_how_to_resume(folder, console), folder:
        written = _open_timeline(folder, sequence, config, watchers)
        shown = _watched(written, folder, config, watchers.live)
        with _closed_in_the_end(shown, folder) as timeline, StopRequest() as stop:
            _show_live(folder, watchers, console)
            run = begin_run(sequence, config, mapper, written, registration)
            checkpoints = _checkpoints(run, sequence, config, folder, vocabulary, console) if is_reopenable else None
            panoptic = map_sequence(
                sequence, config, run, console, shown=timeline, checkpoints=checkpoints, stop=stop, solved=solved
            )
            with waiting_for("ending the timeline", console):
                timeline.finish(panoptic)
            with waiting_for("saving the map", console):
                timings = _save(folder, config, sequence, run, panoptic)
        folder.commit()
    if watchers.live is not None:
        watchers.live.finish(folder.final)
    return RunResult(run.accounting, panoptic, timings, run.registration, config, stop.exit_code)


def _open_timeline(
    folder: RunFolder, sequence: RgbdSequence, config: RunConfig, watchers: Watchers
) -> Timeline | NullTimeline:
    is_live = watchers.viewer is not None
    return open_timeline(folder.partial, sequence, config, before=folder.checkpoint, live=is_live)


def _registration(sequence: RgbdSequence, config: RunConfig, folder: RunFolder, console: Console) -> ColorRegistration:
    """How colour lies to depth; for a run that is resumed none, as its checkpoint has it."""
    if folder.checkpoint is not None:
        return ColorRegistration(sequence.intrinsics)
    _note_leftovers(folder, console)
    return register_color(sequence, config.input.rgbd_calibration, console)


def _show_live(folder: RunFolder, watchers: Watchers, console: Console) -> None:
    if watchers.viewer is not None:
        place = open_live(folder.final, watchers.viewer)
        console.print(f"the run can be watched {place}", soft_wrap=True, highlight=False)


def _note_leftovers(folder: RunFolder, console: Console) -> None:
    for leftover in folder.leftovers():
        console.print(f"note: {leftover} is left from a killed run and can be deleted", soft_wrap=True)
        if (leftover / CHECKPOINT / FILE).exists():
            console.print(f"      razer run --resume {shlex.quote(str(folder.final))} goes on with it", soft_wrap=True)


@contextmanager
def _told_how_to_resume(folder: RunFolder, console: Console) -> Iterator[None]:
    """Whatever ends the run in this context, say so if it can be resumed; a full disk and the like in one line."""
    try:
        yield
    except BaseException as error:
        kept = ""
        if folder.is_resumable:
            kept = f"what was mapped is kept: razer run --resume {shlex.quote(str(folder.final))} goes on"
        if isinstance(error, OSError) and error.errno in NO_ROOM:
            hint = kept or "free some space, or choose another folder with -o"
            raise BadInput(f"{folder.final} could not be written ({error.strerror}); {hint}") from error
        if kept and not isinstance(error, BadInput):
            console.print(f"note: {kept}", soft_wrap=True)
        raise


@contextmanager
def _closed_in_the_end(timeline: Timeline | NullTimeline, folder: RunFolder) -> Iterator[Timeline | NullTimeline]:
    """Close a timeline after this context; its parts stay until the folder is complete, if the run can be resumed."""
    try:
        yield timeline
    except BaseException:
        timeline.close(join=not folder.is_resumable, keep_parts=folder.is_resumable)
        raise
    timeline.close(keep_parts=folder.is_resumable)


def _checkpoints(
    run: OngoingRun,
    sequence: RgbdSequence,
    config: RunConfig,
    folder: RunFolder,
    vocabulary: str | None,
    console: Console,
) -> RunCheckpoints:
    """What writes checkpoints of a run, which goes on from the one that the folder holds, if any."""
    save_config(folder, config, sequence.name)  # by which it is resumed
    plan = RunPlan.of(sequence, selected_frames(sequence, config.input), vocabulary)
    slam = None if config.input.poses == "given" else config.slam
    if (before := folder.checkpoint) is not None:
        plan.require_same(before)
        run.restore(folder.checkpoints, before)
    return RunCheckpoints(folder.checkpoints, plan, slam, config.run.checkpoint_every, console, before)


def _save(
    folder: RunFolder, config: RunConfig, sequence: RgbdSequence, run: OngoingRun, panoptic: PanopticMap
) -> dict[str, Any]:
    """Write all files of a run but its timeline; returns the contents of timings.json."""
    save_run(folder, config, sequence.name, run.mapper, panoptic, run.accounting)
    save_camera(folder, sequence.intrinsics)
    if config.input.poses != "slam":
        save_world(folder, origin_of(sequence))
    save_registration(folder, run.registration)
    reintegrator, accounting = run.mapper.reintegrator, run.accounting
    timings = run.recorder.timings() | {"account": accounting.account().as_json()}
    timings |= {"interrupted": accounting.interrupted, "resumed_at": list(run.resumed_at)}
    if reintegrator is not None:
        timings["rebuilding"] = run.recorder.rebuilding(reintegrator)
    save_timings(folder, timings)
    return timings


def _watched(
    timeline: Timeline | NullTimeline, folder: RunFolder, config: RunConfig, live: LiveRun | None
) -> Timeline | NullTimeline:
    if live is None:
        return timeline
    live.start(folder.partial, config)
    return live.timeline(timeline)
