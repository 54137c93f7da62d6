"""The mapping pipeline: one run from an open sequence to a finished run folder."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import open3d as o3d
import torch
from rich.console import Console

from app.console.progress import show_progress
from app.console.waiting import waiting_for
from app.frames.color_registration import ColorRegistration, register_color
from app.frames.frame_accounting import FrameAccounting
from app.frames.packet_stream import packet_stream
from app.frames.prefetch_process import prefetch
from app.frames.selection import selected_frames
from app.pipeline.interrupt import StopRequest, until_interrupted
from app.pipeline.main_loop import map_frames
from app.pipeline.stored_masks import note_stored_masks
from app.pipeline.watchers import NOBODY, Watchers
from app.profiling.map_device import MapDevice
from app.profiling.memory import rss_mb
from app.profiling.recorder import Recorder
from app.run_folder.run_folder import TIMELINE, RunFolder
from app.run_folder.save_run import save_camera, save_registration, save_run, save_timings
from app.settings.run_config import RunConfig
from app.timeline.null_timeline import NullTimeline
from app.timeline.viewer.live_viewer import open_live
from data_tools.recordings.color_warp import ColorWarp
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import BadInput
from razer.mapper import Mapper
from razer.models.automatic_choice import automatic_choice
from razer.panoptic_map import PanopticMap
from slam.poses import GivenPoses, Poses

if TYPE_CHECKING:
    from app.live.live_run import LiveRun
    from app.timeline.rerun_timeline import Timeline


@dataclass(frozen=True)
class RunResult:
    """What a run made: the account of its frames, the map, the contents of timings.json, and the settings with every
    choice made."""

    accounting: FrameAccounting
    panoptic: PanopticMap
    timings: dict[str, Any]
    registration: ColorRegistration
    config: RunConfig


def run_to_folder(
    sequence: RgbdSequence, config: RunConfig, folder: RunFolder, console: Console, watchers: Watchers = NOBODY
) -> RunResult:
    """Map `sequence` and leave everything in `folder`, or nothing at all if it fails; a Ctrl-C keeps what was mapped.

    Args:
        sequence: the recording.
        config: the settings.
        folder: where the run goes.
        console: where progress is shown.
        watchers: who sees the run while it goes on.

    Raises:
        BadInput: for input or settings that cannot be used.
    """
    config, note = resolve_models(resolve_poses(config, sequence))
    with waiting_for("loading the 2D models", console):
        mapper = make_mapper(config)
    note_stored_masks(mapper.perception.segmenter, selected_frames(sequence, config.input), console)
    for leftover in folder.leftovers():
        console.print(f"note: {leftover} is left from a killed run and can be deleted", soft_wrap=True)
    registration = register_color(sequence, config.input.rgbd_calibration, console)
    print_model_note(note, console)  # after all that can be refused: who has to ask anew reads one line
    with folder:
        written = open_timeline(folder.partial, sequence, config, live=watchers.viewer is not None)
        with closing(_watched(written, folder, config, watchers.live)) as timeline:
            if watchers.viewer is not None:
                place = open_live(folder.final, watchers.viewer)
                console.print(f"the run can be watched {place}", soft_wrap=True, highlight=False)
            warp = registration.warp
            accounting, recorder, panoptic = map_sequence(sequence, config, mapper, timeline, console, warp)
            if not accounting.used:
                raise KeyboardInterrupt  # stopped before the first frame: there is nothing to keep
            with waiting_for("ending the timeline", console):
                timeline.finish(panoptic)
        with waiting_for("saving the map", console):
            save_run(folder, config, sequence.name, mapper, panoptic, accounting)
        save_camera(folder, sequence.intrinsics)
        save_registration(folder, registration)
        timings = recorder.timings() | {"account": accounting.account().as_json()}
        if mapper.reintegrator is not None:
            timings["rebuilding"] = recorder.rebuilding(mapper.reintegrator)
        save_timings(folder, timings)
        folder.commit()
    if watchers.live is not None:
        watchers.live.finish(folder.final)
    return RunResult(accounting, panoptic, timings, registration, config)


def _watched(
    timeline: Timeline | NullTimeline, folder: RunFolder, config: RunConfig, live: LiveRun | None
) -> Timeline | NullTimeline:
    if live is None:
        return timeline
    live.start(folder.partial, config)
    return live.timeline(timeline)


def map_sequence(
    sequence: RgbdSequence,
    config: RunConfig,
    mapper: Mapper,
    timeline: Timeline | NullTimeline,
    console: Console,
    color_warp: ColorWarp | None = None,
) -> tuple[FrameAccounting, Recorder, PanopticMap]:
    """Run the main loop with progress shown; a Ctrl-C ends it early, and `interrupted` of the account says so.

    Args:
        sequence: the recording.
        config: the settings, with the choice of poses made.
        mapper: the method, which takes in the frames and is finished then.
        timeline: where it is shown.
        console: where progress is shown.
        color_warp: brings colour onto depth; None = it lies there.

    Raises:
        BadInput: where too many frames cannot be used, or none was located.
    """
    indices = selected_frames(sequence, config.input)
    accounting = FrameAccounting(sequence.name, len(indices), config.input.max_bad)
    recorder = Recorder(len(indices), lambda: mapper.voxels.n_blocks, MapDevice(str(mapper.voxels.device)))

    def status() -> str:
        confirmed = sum(track.confirmed for track in mapper.tracks)
        return f"{recorder.frames_per_s:.1f} frames/s, {confirmed} instances, {rss_mb():.0f} MB"

    stream = packet_stream(sequence, indices, poses_of(config), mapper.perception, color_warp)
    with StopRequest() as stop, stream as packets:
        shown = show_progress(
            until_interrupted(packets, stop),
            len(indices),
            status,
            console,
            first="starting the 2D models and the first frame",
        )
        map_frames(shown, mapper, timeline, recorder, accounting)
        accounting.interrupted = stop.requested
    accounting.require_used()
    with waiting_for("mapping the kept frames once more at their final poses", console):
        for _ in recorder.afterwards(mapper.catch_up(prefetch)):
            pass
    with waiting_for("finishing the map", console):
        panoptic = mapper.finish()
    return accounting, recorder, panoptic


def make_mapper(config: RunConfig) -> Mapper:
    """The method with the models and on the device that the settings name; raises BadInput."""
    # The method's tensors are small: threads that wait for each other cost more than they bring.
    torch.set_num_threads(1)
    return Mapper(config, device=_device(config.run.device))


def resolve_poses(config: RunConfig, sequence: RgbdSequence) -> RunConfig:
    """The settings with the choice of poses made, and what follows from it: frames are reintegrated where poses are
    estimated. Raises BadInput where poses are asked for that the sequence does not have."""
    choice = config.input.poses
    if choice == "auto":
        choice = "given" if sequence.has_poses else "slam"
    if choice == "given":
        require_poses(sequence)
    return config.model_copy(
        update={
            "input": config.input.model_copy(update={"poses": choice}),
            "reintegration": config.reintegration.model_copy(update={"enabled": choice == "slam"}),
        }
    )


def resolve_models(config: RunConfig) -> tuple[RunConfig, str]:
    """The settings with the choice of models made, and what "auto" stands for in one line, '' where nothing was to
    choose. Raises BadInput."""
    choice = automatic_choice(config.segmenter, config.embedder)
    return config.model_copy(update={"segmenter": choice.segmenter, "embedder": choice.embedder}), choice.note


def print_model_note(note: str, console: Console) -> None:
    """Show what `resolve_models` says, if anything."""
    if note:
        console.print(note, soft_wrap=True, highlight=False, markup=False)


def poses_of(config: RunConfig) -> Callable[[], Poses]:
    """What makes the source of poses, by settings with the choice of poses made."""
    if config.input.poses != "slam":
        return GivenPoses
    from slam.system import SlamSystem

    return partial(SlamSystem, config.slam)


def require_poses(sequence: RgbdSequence) -> None:
    """Raise BadInput if the sequence has no poses at all."""
    if not sequence.has_poses:
        raise BadInput(
            f"{sequence.name}: no camera poses found; --poses slam estimates them, or add trajectory.txt with "
            "lines 'stamp tx ty tz qx qy qz qw' (world from camera), or name the layout with --reader"
        )


def _device(choice: str) -> str:
    # Both, as the volume's attributes are shared between them: a torch without CUDA beside an Open3D with it is common.
    lacking = [name for name, library in (("Open3D", o3d.core), ("torch", torch)) if not library.cuda.is_available()]
    if choice == "cuda" and lacking:
        raise BadInput(
            f"--device cuda: {' and '.join(lacking)} {'find' if len(lacking) > 1 else 'finds'} no CUDA device here; "
            "use --device cpu or auto, or install builds with CUDA"
        )
    return "CPU:0" if lacking or choice == "cpu" else "CUDA:0"


def open_timeline(
    folder: Path, sequence: RgbdSequence, config: RunConfig, *, live: bool = False
) -> Timeline | NullTimeline:
    """A timeline that is written into `folder`, soon enough to be watched where it is `live`; or one that ignores
    everything if the settings say so."""
    if not config.run.timeline:
        return NullTimeline()
    from app.timeline.rerun_timeline import Timeline

    return Timeline(folder / TIMELINE, sequence.intrinsics, config.timeline, live=live)
