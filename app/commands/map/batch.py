"""`razer batch`: many recordings become maps, on this machine or on a cluster."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from app.batch.report import LOGS, REPORT, print_report
from app.console.outputs import print_next, print_outputs
from app.console.streams import print_notes, progress_console, result_console
from app.engines.engine_options import PlacingOptions
from app.next_steps import looking_at
from app.object_store.place import Place
from app.pipeline.interrupt import FAILED
from app.run_folder.folder_lock import writing
from app.settings.options import MODELS, Flag, RunOptions
from app.verbs import named
from razer.errors import BadInput
from razer.vocabulary import vocabulary as read_vocabulary

if TYPE_CHECKING:
    from app.batch.report import BatchReport

OUTPUTS = {REPORT: "what became of each scene", LOGS: "what each attempt said"}


def run(
    scenes: str,
    /,
    *,
    out: Annotated[str, Parameter(name=["--out", "-o"])],
    placing: PlacingOptions = PlacingOptions(),  # noqa: B008
    options: RunOptions = RunOptions(),  # noqa: B008
    vocabulary: Annotated[str | None, Parameter(group=MODELS)] = None,
    eval: Annotated[str, Parameter(show_default=False)] = "",
    resume: Flag = False,
    json: Flag = False,
) -> int:
    """Map each of many recordings as `razer run` would alone, several at once, the longest first.

    A scene that fails is tried three times where that may help: with more memory, or on another node. Ctrl-C loses no
    finished scene, and --resume goes on with the others from their checkpoints.

    Parameters
    ----------
    scenes:
        A folder of recordings, a list file with a path or URI a line, or a URI such as s3://BUCKET/scans.
    out:
        The folder, or URI, for a run folder a scene, report.json and batch_logs.
    vocabulary:
        Name the instances of each map, as with `razer run`.
    eval:
        Evaluate each map whose recording has a truth by the rules of this preset, as `razer eval --scenes` would.
    resume:
        Go on with a batch to this place: what is done stays, all else is tried again.
    json:
        End standard output with the report on one line.
    """
    from app.batch.begin import BatchPlan, begin
    from app.batch.scenes import scenes_of

    if vocabulary is not None:
        read_vocabulary(vocabulary)
    plan = BatchPlan.of(options, vocabulary, placing.cores, placing.gpus, eval)
    target, console = Place.of(out), progress_console()
    _note_untried(Place.of(scenes), target)
    with nullcontext() if target.is_remote else writing(target.path / REPORT):
        batch, report = begin(scenes_of(scenes), target, plan, placing.engine, console, resume=resume)
        try:
            batch.run()
        finally:
            _deliver(report, target, as_json=json)
        if batch.evaluations:
            _pool(batch.evaluations, eval, target, as_json=json)
    return FAILED if report.n_failed else 0


def simulate(
    report: Path,
    /,
    *,
    workers: int,
    scenes: int | None = None,
    straggler_share: float = 0.0,
    straggler_times: float = 3.0,
    hours_between_failures: float = 0.0,
    restart_s: float = 300.0,
    dispatch_s: float = 0.003,
    seed: int = 0,
    json: Flag = False,
) -> int:
    """Say how long a batch would take with other workers, or more scenes: what was measured, simulated.

    Parameters
    ----------
    report:
        The report.json of a batch.
    workers:
        Scenes that are mapped at once.
    scenes:
        How many, each as long as one of those measured. Not given: those measured.
    straggler_share:
        Share of the scenes, in [0, 1], that take longer.
    straggler_times:
        How many times as long they take.
    hours_between_failures:
        Of one worker, on average; 0: none ever fails.
    restart_s:
        Seconds until a worker that failed is there again.
    dispatch_s:
        Seconds that handing out one scene takes, one after the other.
    seed:
        Another course of events.
    json:
        Print the figures as one line of JSON.
    """
    from app.batch.simulation.discrete_events import Cluster
    from app.batch.simulation.discrete_events import simulate as simulated
    from app.batch.simulation.measured_batch import MeasuredBatch

    if scenes is not None and scenes < 1:
        raise BadInput(f"--scenes {scenes}: give at least 1")
    cluster = Cluster(workers, dispatch_s, straggler_share, straggler_times, hours_between_failures, restart_s)
    measured = MeasuredBatch.read(report)
    figures = simulated(measured.drawn(scenes, seed), cluster, seed).as_json() | {"measured_s": measured.total_s}
    _print_figures(figures, as_json=json)
    return 0


def _print_figures(figures: Mapping[str, float], *, as_json: bool) -> None:
    if as_json:
        print(dumps(figures))
        return
    for name, value in figures.items():
        result_console().print(f"{name}: {value}", highlight=False)


def _note_untried(*places: Place) -> None:
    for place in places:
        if not place.is_tried:
            print_notes([f"{place}: stores of this kind are untried; file:// and s3:// are tested"])


def _deliver(report: BatchReport, out: Place, *, as_json: bool) -> None:
    """The report for people, or for programs; also of a batch that was ended."""
    if as_json:
        print(dumps(report.as_json()))
        return
    print_report(report, result_console())
    if out.is_remote:
        return
    print_outputs(out.path, OUTPUTS)
    done = [name for name, record in report.scenes.items() if record.status == "done"]
    print_next(*(looking_at(out.path / name) for name in done[:1]))


def _pool(evaluations: Mapping[str, bytes], preset: str, out: Place, *, as_json: bool) -> None:
    """What the maps are worth together, in evaluation.json, and each by itself in the metrics.json of its run."""
    from app.batch.scene_evaluation import pool
    from app.evaluation.report import report

    result = pool(evaluations, preset, out)
    if not as_json:
        report(result, result_console())


verb = App(name="batch", help_format="markdown", help_epilogue=named("batch").epilogue)
verb.command(run, name="run", help_epilogue=named("batch").epilogue)
verb.command(simulate, name="simulate")
