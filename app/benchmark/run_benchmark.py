"""The benchmark of `razer bench`: a run that keeps nothing, plain TSDF fusion of the same frames, and single parts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rich.console import Console

from app.benchmark.backend_cpu import BACKEND, measure_backend_cpu
from app.benchmark.decoding import measure_decoding
from app.benchmark.describing import measure_describing
from app.benchmark.evaluating import measure_evaluation
from app.benchmark.plain_fusion import PlainFusion
from app.benchmark.ranking import measure_ranking
from app.benchmark.registering import measure_registering
from app.benchmark.synth import measure_synth
from app.console.streams import progress_console
from app.console.waiting import waiting_for
from app.frames.cameras.color_registration import register_color
from app.frames.open_recording import open_recording, require_poses
from app.frames.selection import selected_frames
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
from app.profiling.map_device import MapDevice
from app.profiling.stage_summary import summarize
from app.settings.run_config import RunConfig
from data_tools.recordings.sequence import RgbdSequence
from data_tools.synthetic.synthetic_room import SyntheticRoom
from razer.errors import UnusableFrame
from razer.frame import Frame

ROOM_FRAMES = 120
CPU_FRAMES = 200  # the first ones, mapped once more for their processor time


def run_benchmark(folder: Path | None, config: RunConfig, parts: bool = True) -> dict[str, Any]:
    """The figures of one run over a recording, or over a synthetic room where there is none: those of timings.json,
    each stage's share, the time of plain fusion (key `yardstick`) and the ratios to it, and with `parts` those of what
    is measured alone: the map's processor time, rendering, evaluation, decoding and describing of masks, a query,
    bringing colour onto depth. Raises BadInput."""
    console = progress_console()
    sequence = open_recording(folder, config.input, console) if folder else _room(config)
    require_poses(sequence)  # plain fusion has no others
    config, note = resolve_models(resolve_poses(config, sequence))
    registration = register_color(sequence, config.input.rgbd_calibration, console)
    print_model_note(note, console)
    solved = solved_poses(sequence, config, console)
    with waiting_for("loading the 2D models", console):
        mapper = make_mapper(config)
    with TemporaryDirectory() as scratch, closing(open_timeline(Path(scratch), sequence, config)) as timeline:
        run = begin_run(sequence, config, mapper, timeline, registration)
        panoptic = map_sequence(sequence, config, run, console, solved=solved)
        with waiting_for("ending the timeline", console):
            timeline.finish(panoptic)
        timings = run.recorder.timings()
    n_blocks, device = mapper.voxels.n_blocks, MapDevice(str(mapper.voxels.device))
    del mapper, run
    with waiting_for("plain TSDF fusion of the same frames", console):
        fusion = PlainFusion(config.voxels, n_blocks, device)
        plain = summarize([fusion.fuse_ms(frame) for frame in _posed_frames(sequence, config)])
    figures = {
        "name": sequence.name,
        "segmenter": config.segmenter.name,
        "embedder": config.embedder.name,
        **_with_shares(timings),
        "yardstick": plain,
        "ratios": _ratios(timings, plain),
    }
    return figures | _parts(sequence, config, console) if parts else figures


def _parts(sequence: RgbdSequence, config: RunConfig, console: Console) -> dict[str, Any]:
    """The parts that are measured alone."""
    with waiting_for("the map once more, by its processor time", console):
        cpu = measure_backend_cpu(list(islice(_posed_frames(sequence, config), CPU_FRAMES)), config)
    parts: dict[str, tuple[str, Callable[[], Any]]] = {
        "synth": ("rendering synthetic frames", measure_synth),
        "evaluation": ("evaluating masks", measure_evaluation),
        "yolo_decoding": ("decoding masks", measure_decoding),
        "describing": ("describing masks", measure_describing),
        "ranking": ("asking a large map", measure_ranking),
        "registering": ("bringing colour onto depth", measure_registering),
    }
    figures = {"backend_cpu": cpu}
    for name, (what, measure) in parts.items():
        with waiting_for(what, console):
            figures[name] = measure()
    return figures


def _room(config: RunConfig) -> SyntheticRoom:
    return SyntheticRoom(n_frames=config.input.max_frames or ROOM_FRAMES)


def _posed_frames(sequence: RgbdSequence, config: RunConfig) -> Iterator[Frame]:
    """The frames that the run could use."""
    for index in selected_frames(sequence, config.input):
        with suppress(UnusableFrame):
            frame = sequence[index]
            if frame.world_from_camera is not None:
                yield frame


def _with_shares(timings: dict[str, Any]) -> dict[str, Any]:
    """Timings whose stages also have their share in [0, 1] of the time of all stages."""
    busy_s = sum(stage["total_s"] for stage in timings["stages"].values()) or 1.0
    stages = {name: {**stage, "share": stage["total_s"] / busy_s} for name, stage in timings["stages"].items()}
    return {**timings, "stages": stages}


def _ratios(timings: dict[str, Any], plain: dict[str, float]) -> dict[str, float]:
    """Time of the run's fusion, and of all map stages together (BACKEND), over that of plain fusion."""
    stages = timings["stages"]
    backend_s = sum(stages[name]["total_s"] for name in BACKEND if name in stages)
    integrate_s = stages.get("integrate", {"total_s": 0.0})["total_s"]
    plain_s = plain["total_s"] or float("nan")
    return {"integrate": round(integrate_s / plain_s, 3), "backend": round(backend_s / plain_s, 3)}
