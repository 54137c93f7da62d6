"""`razer bench`: time of each stage and memory of a run, beside plain TSDF fusion as the baseline; `razer bench poses`:
pose estimation in hard worlds."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from json import dumps
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import App, Group, Parameter

from app.console.leaving import begin_helper
from app.console.outputs import Words, print_next
from app.console.streams import progress_console, result_console
from app.console.waiting import waiting_for
from app.next_steps import mapping, new_run
from app.settings.extra_libraries import require_library, require_serve
from app.settings.number_lists import whole_numbers
from app.settings.options import Flag, RunOptions
from app.verbs import named
from razer.errors import BadInput

if TYPE_CHECKING:
    from app.benchmark.poses.worlds.hard_worlds import HardWorld
    from app.settings.run_config import RunConfig


def bench(
    folder: Path | None = None,
    /,
    *,
    options: RunOptions = RunOptions(),  # noqa: B008
    repeat: int = 1,
    details: Flag = False,
    masks: Flag = False,
    recognition: Flag = False,
    serve: Flag = False,
    json: Flag = False,
) -> None:
    """Measure time per stage and memory of a run that writes nothing, beside plain TSDF fusion.

    Parameters
    ----------
    folder:
        The recording; a synthetic room if not given. One that is called `poses` is given as ./poses.
    repeat:
        How many runs, each in a process of its own; the one of median speed is shown.
    details:
        Show each stage, memory along the way, and parts measured alone: rendering, evaluation, a query. --json has them
        always.
    masks:
        Measure, instead, the segmenter on the recording: which masks of a view are missed in the next, which change
        their names, and how well they fit, by depth and poses; no truth is needed.
    recognition:
        Measure, instead, the segmenter against the instance ids of a recording that has them: how many of the seen
        things of 15 household classes it finds by name, and the IoU of walls, floors, ceilings, doors, beds and tables.
    serve:
        Measure, instead, how long queries take that 50 clients put to a served map of 500 instances at once.
    json:
        One line of JSON.
    """
    if serve:
        _measure_serving(json)
        return
    if repeat < 1:
        raise BadInput(f"--repeat {repeat}: give at least 1")
    config = options.read()
    if masks or recognition:
        _measure_masks(folder, options, config, recognition, json)
        return

    _measure_run(folder, options, config, repeat, details, json)


def _measure_run(
    folder: Path | None, options: RunOptions, config: RunConfig, repeat: int, details: bool, json: bool
) -> None:
    with waiting_for("starting"):
        from app.benchmark.report import print_bench, print_details  # late, as in `razer run`
        from app.benchmark.run_benchmark import run_benchmark

    spawn = get_context("spawn")
    with ProcessPoolExecutor(1, spawn, begin_helper, max_tasks_per_child=1) as pool:
        runs = list(pool.map(run_benchmark, [folder] * repeat, [config] * repeat, [details or json] * repeat))
    median = sorted(runs, key=lambda run: float(run["fps"]))[(repeat - 1) // 2]
    result = {**median, "repeat": repeat, "fps_of_runs": [run["fps"] for run in runs]}
    if json:
        print(dumps(result))
        return
    print_bench(result)
    if details:
        print_details(result)
    print_next(_next_step(folder, options))


def _next_step(folder: Path | None, options: RunOptions) -> Words:
    """To map what was measured; of the synthetic room, to map that."""
    return ("demo", "-o", new_run(Path("demo"))) if folder is None else mapping(folder, *options.words())


def _measure_masks(
    folder: Path | None, options: RunOptions, config: RunConfig, is_recognition: bool, json: bool
) -> None:
    with waiting_for("starting"):
        from app.mask_quality.measure_masks import measure_masks, print_masks
        from app.mask_quality.measure_recognition import measure_recognition, print_recognition

    if folder is None:
        option = "--recognition" if is_recognition else "--masks"
        raise BadInput(f"{option} needs a recording: razer bench FOLDER {option}")
    measure, show = (measure_recognition, print_recognition) if is_recognition else (measure_masks, print_masks)
    result = measure(folder, config)
    if json:
        print(dumps(result))
        return
    show(result)
    print_next(mapping(folder, *options.words()))


def _measure_serving(json: bool) -> None:
    require_serve()
    with waiting_for("asking a served map of many instances"):
        from app.server.measure_load import measure_serving, print_serving

        result = measure_serving()
    if json:
        print(dumps(result))
        return
    print_serving(result)
    print_next(("demo", "-o", new_run(Path("demo"))))


def poses(
    recording: Path | None = None,
    /,
    *,
    worlds: Annotated[str, Parameter(show_default=False)] = "",
    frames: int = 0,
    seed: Annotated[str, Parameter(name=("--seed", "--seeds"))] = "1,2,3",
    calibration: Flag = False,
    json: Flag = False,
) -> None:
    """Measure pose estimation in synthetic worlds that make it hard, or on a recording that is blinded, cut and turned.

    What is tracked, how soon a lost camera is found, which places are taken for others, how exact poses are, and how
    right their covariances. Nothing is written; all worlds take some 45 minutes, see docs/pose_benchmark.md.

    Parameters
    ----------
    recording:
        A recording with poses, which count as true: recorded, backwards, to-and-fro, blinded, blinking, cut,
        backwards-cut, jumping, shuffled, no-light, sparse-8, sparse-16, sparse-8-in-order, sparse-16-in-order.
    worlds:
        Only these, by name with commas between: stride-1, stride-2, stride-4, stride-8, stride-16, plain-sensor, vga,
        blind-1s, blind-10s, re-lit, to-and-fro, people, dark, no-light, blank-walls, fast-turns, misregistered,
        look-alikes, twin-rooms, blind-between-twins, sparse-room, sparse-room-1s, sparse-apartment, sparse-look-alikes,
        sparse-twin-rooms, sparse-look-alikes-in-order, sparse-twin-rooms-in-order.
    frames:
        At most so many of each walk; 0 = as many as it usually has.
    seed:
        Seeds of the worlds, with commas between; the table is over all of them, --json has each.
    calibration:
        Instead, whether the covariances of poses are as large as their errors, in other worlds, that are not hard, and
        with two sensors; each run has a line.
    json:
        One line of JSON.
    """
    if frames < 0:
        raise BadInput(f"--frames {frames}: give 0 or more")
    seeds = whole_numbers("--seed", seed, 0)
    with waiting_for("starting"):
        from app.benchmark.poses.calibration import summary
        from app.benchmark.poses.run_poses import chosen_worlds, measure_poses

    chosen = chosen_worlds(worlds.split(",") if worlds else (), _worlds(recording, calibration))
    rows = measure_poses(chosen, seeds, frames or None, progress_console())
    together = {"calibration": summary(rows)} if calibration else {}
    if json:
        print(dumps({"format": 1, "seeds": seeds, "frames": frames, "runs": rows} | together))
        return
    _print_poses(rows, calibration)
    print_next(("config",))  # the settings of the pose estimation are among them


def _print_poses(rows: list[dict[str, Any]], calibration: bool) -> None:
    from app.benchmark.poses.calibration import calibration_table, described, summary
    from app.benchmark.poses.report import poses_table

    result_console().print(calibration_table(rows) if calibration else poses_table(rows))
    if calibration:
        result_console().print(described(summary(rows)), soft_wrap=True, highlight=False)


def _worlds(recording: Path | None, calibration: bool) -> dict[str, HardWorld]:
    """All that there are to choose from; raises BadInput for a recording without poses."""
    from app.benchmark.poses.worlds.calibration_worlds import CALIBRATION_WORLDS
    from app.benchmark.poses.worlds.hard_worlds import WORLDS

    if recording is None:
        return CALIBRATION_WORLDS if calibration else WORLDS
    if calibration:
        raise BadInput("--calibration is of synthetic worlds, whose poses are exact: leave the recording out")
    from app.benchmark.poses.worlds.recorded_walks import PosedRecording, recorded_worlds
    from app.frames.open_recording import open_unchecked
    from app.settings.run_config import InputSettings

    with waiting_for("reading the poses"):
        return recorded_worlds(PosedRecording.of(open_unchecked(recording, InputSettings())))


def library(*, instances: int = 100_000, vectors: Path | None = None, queries: int = 100, json: Flag = False) -> None:
    """Measure a library of maps: time and recall of searches, bytes of an instance, time to add a map.

    It is made in the folder for temporary files, and takes some 2 kB there for each instance until it is removed.

    Parameters
    ----------
    instances:
        How many there are, in maps of 100; from 100,000 on they are indexed.
    vectors:
        An npz with names, synonyms, text and image, whose image vectors are seen through noise; made up if not given.
    queries:
        How many of each kind are asked.
    json:
        One line of JSON.
    """
    require_library()
    if instances < 1000 or queries < 1:
        raise BadInput("--instances is at least 1000, and --queries at least 1")
    with waiting_for("making and asking a library"):
        from app.benchmark.measure_library import measure_library, print_library

        result = measure_library(instances, vectors, queries)
    if json:
        print(dumps(result))
        return
    print_library(result)
    print_next(("library", "add", "RUN", "--library", "maps.lance"))


verb = App(name="bench", help_format="markdown", help_epilogue=named("bench").epilogue)
verb.default(bench)
_instead = Group("Instead")
verb.command(poses, name="poses", group=_instead, help_epilogue=named("bench").epilogue)
verb.command(library, name="library", group=_instead, help_epilogue=named("bench").epilogue)
