"""Preparation of a run: settings with every choice made, the method with its models, and where it is shown."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import open3d as o3d
import torch
from rich.console import Console

from app.checkpoints.ongoing_run import OngoingRun
from app.frames.cameras.color_registration import ColorRegistration
from app.frames.frame_accounting import FrameAccounting
from app.frames.open_recording import require_poses
from app.frames.second_attempt import SecondAttempt
from app.frames.selection import selected_frames
from app.pipeline.picture_rate import is_sparse, require_estimated
from app.profiling.map_device import MapDevice
from app.profiling.recorder import Recorder
from app.run_folder.run_folder import TIMELINE
from app.settings.run_config import RunConfig
from app.stored_state.checkpoint import Checkpoint
from app.timeline.null_timeline import NullTimeline
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import BadInput
from razer.mapper import Mapper
from razer.models.automatic_choice import automatic_choice
from slam.poses import GivenPoses, Poses

if TYPE_CHECKING:
    from app.timeline.rerun_timeline import Timeline
    from slam.sparse.solved_poses import SolvedPoses


def begin_run(
    sequence: RgbdSequence,
    config: RunConfig,
    mapper: Mapper,
    timeline: Timeline | NullTimeline,
    registration: ColorRegistration,
) -> OngoingRun:
    """A run before its first frame; settings with the choice of poses made."""
    n_frames = len(selected_frames(sequence, config.input))
    accounting = FrameAccounting(sequence.name, n_frames, config.input.max_bad)
    recorder = Recorder(n_frames, lambda: mapper.voxels.n_blocks, MapDevice(str(mapper.voxels.device)))
    return OngoingRun(mapper, accounting, recorder, timeline, registration)


def make_mapper(config: RunConfig) -> Mapper:
    """The method with the models and on the device that the settings name; raises BadInput."""
    # The method's tensors are small: threads that wait for each other cost more than they bring.
    torch.set_num_threads(1)
    return Mapper(config, device=_device(config.run.device))


def resolve_poses(config: RunConfig, sequence: RgbdSequence) -> RunConfig:
    """The settings with the choice of poses made, and what follows from it: frames are reintegrated where poses change
    as the run goes on. Raises BadInput where poses are asked for that the sequence does not have, or that cannot be
    estimated as they are to be."""
    choice = config.input.poses
    if choice == "auto":
        choice = "given" if sequence.has_poses and not config.input.sparse else "slam"
    sparse = config.input.sparse
    if choice != "slam":
        require_estimated(choice, sparse)
        require_poses(sequence)
    elif is_sparse(sequence, selected_frames(sequence, config.input), config.input):
        sparse = True
    change = choice == "refine" or (choice == "slam" and not sparse)
    return config.model_copy(
        update={
            "input": config.input.model_copy(update={"poses": choice, "sparse": sparse}),
            "reintegration": config.reintegration.model_copy(update={"enabled": change}),
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


def poses_of(config: RunConfig, solved: SolvedPoses | None = None) -> Callable[[], Poses]:
    """What makes the source of poses, by settings with the choice of poses made; `solved`: those that are known."""
    if solved is not None:
        return partial(copy, solved)
    if config.input.poses == "given":
        return GivenPoses
    if config.input.poses == "refine":
        from slam.refinement import RefinedPoses

        return partial(RefinedPoses, config.slam)
    from slam.system import SlamSystem

    return partial(SlamSystem, config.slam)


def second_attempt(sequence: RgbdSequence, config: RunConfig) -> SecondAttempt | None:
    """What is done where following the camera fails; None where poses are not estimated so, or --no-sparse forbids
    it."""
    if config.input.poses != "slam" or config.input.sparse is not None:
        return None
    return SecondAttempt(sequence, selected_frames(sequence, config.input), config.slam)


def solved_poses(sequence: RgbdSequence, config: RunConfig, console: Console) -> SolvedPoses | None:
    """The poses of pictures that are matched all at once, by settings with the choice of poses made; None where they
    are given, or estimated as the run goes on."""
    if config.input.poses != "slam" or not config.input.sparse:
        return None
    from app.pipeline.sparse_pictures import match_pictures, pace, print_matched
    from slam.sparse.solved_poses import SolvedPoses

    indices = selected_frames(sequence, config.input)
    system = match_pictures(sequence, indices, config.slam, console)
    print_matched(system, pace(sequence, indices), console)
    return SolvedPoses.of(system)


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
    folder: Path, sequence: RgbdSequence, config: RunConfig, *, before: Checkpoint | None = None, live: bool = False
) -> Timeline | NullTimeline:
    """A timeline that is written into `folder`, on from the checkpoint `before`, soon enough to be watched where it is
    `live`; or one that ignores everything if the settings say so."""
    if not config.run.timeline:
        return NullTimeline()
    from app.timeline.rerun_timeline import Timeline

    written = None if before is None else before.timeline
    return Timeline(folder / TIMELINE, sequence.intrinsics, config.timeline, live=live, written=written)
