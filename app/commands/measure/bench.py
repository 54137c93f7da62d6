"""`razer bench`: time of each stage and memory of a run, beside plain TSDF fusion as the baseline."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from json import dumps
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING

from app.console.leaving import begin_helper
from app.console.outputs import Words, print_next
from app.console.waiting import waiting_for
from app.next_steps import mapping, new_run
from app.settings.extra_libraries import require_serve
from app.settings.options import Flag, RunOptions
from razer.errors import BadInput

if TYPE_CHECKING:
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
        The recording; a synthetic room if not given.
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
