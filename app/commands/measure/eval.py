"""`razer eval`: evaluation of a map, or of another system's prediction, against the ground truth."""

from __future__ import annotations

from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from app.console.streams import print_notes, result_console
from app.run_folder import run_folder
from app.run_folder.atomic_files import replace_content
from app.settings.options import Assignments, Flag, TrustOptions
from razer.errors import BadInput

if TYPE_CHECKING:
    from razer.metrics.protocol.evaluation import Evaluation

PLOTS = "eval"


def evaluate(
    run: Path | None = None,
    /,
    *,
    truth: Path,
    preset: str = "default",
    set: Assignments = (),
    names: Literal["auto", "run", "text"] = "auto",
    labels: Literal["instance", "class"] = "instance",
    scene: str | None = None,
    scenes: Path | None = None,
    runs: Path | None = None,
    strict: Flag = False,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    options: TrustOptions = TrustOptions(),  # noqa: B008
    json: Flag = False,
) -> int:
    """Evaluate instances, classes, surface and poses against the ground truth.

    Parameters
    ----------
    run:
        A run folder, a submission to the ScanNet benchmark, or a file with a label for each vertex of the truth.
    truth:
        The folder with the truth, or with a recording that holds one; with --scenes the folder that holds them.
    preset:
        Evaluation protocol: default, scannet200, scenenn, hovsg, conceptgraphs, ovo, rayfronts, ovi-map or retrieval.
    set:
        One rule of the protocol as name=value; may be repeated.
    names:
        Where a run's instances get their classes: from the run; by text, from the truth's class names; or by text
        only if the run has none (auto).
    labels:
        Meaning of numbers below 1000 in a file of vertex labels; from 1000 on they are class * 1000 + instance.
    scene:
        Which scene, where a folder holds several.
    scenes:
        A text file with one scene a line, for many scenes at once: runs are in --runs, truths in --truth.
    runs:
        The folder that holds a run folder (or submission) for each scene.
    strict:
        A missing scene is an error instead of a note.
    out:
        The folder for plots: confusion matrix and precision-recall curves; eval in the run folder if not given.
    json:
        One line of JSON.
    """
    # Late, since these bring Open3D and torch along.
    from app.evaluation.evaluate_run import evaluate_jobs
    from app.evaluation.prediction import is_run
    from app.evaluation.rules import choose_rules

    rules = choose_rules(preset, set)
    notes: list[str] = []
    jobs = _jobs(run, truth, scenes, runs, strict, notes)
    result = evaluate_jobs(jobs, rules, naming=names, scene=scene, labels=labels, trust=options.trust, notes=notes)
    notes += [f"class '{name}' is in no list known here: it counts as no class" for name in result.unknown_names]
    print_notes(notes)
    _deliver(result, run if run is not None and is_run(run) else None, out, json)
    return 0


def _deliver(result: Evaluation, run: Path | None, pictures: Path | None, json: bool) -> None:
    """Write metrics and plots into the run folder, if there is one, and print the metrics."""
    from app.evaluation.report import report

    content = result.as_json()
    if run is not None:
        replace_content(run / run_folder.METRICS, dumps(content, indent=1) + "\n")
        pictures = pictures or run / PLOTS
    if pictures is not None:
        _draw(result, pictures)
    if json:
        print(dumps(content))
    else:
        report(result, result_console(), pictures)


def _jobs(
    run: Path | None, truth: Path, scenes: Path | None, runs: Path | None, strict: bool, notes: list[str]
) -> list[tuple[str, Path, Path]]:
    """What to evaluate, (name, prediction, folder with the truth)."""
    if scenes is None:
        if run is None:
            raise BadInput("give a run to evaluate, or --scenes LIST with --runs DIR")
        return [(run.absolute().name, run, truth)]
    if run is not None or runs is None:
        raise BadInput("--scenes LIST needs --runs DIR and no single run")
    try:
        listed = [line.strip() for line in scenes.read_text().splitlines() if line.strip()]
    except OSError as error:
        raise BadInput(f"{scenes} cannot be read: {error.strerror}") from None
    jobs = [(name, path, truth / name) for name in listed if (path := _prediction_path(runs, name)) is not None]
    missing = [name for name in listed if _prediction_path(runs, name) is None]
    if missing and (strict or not jobs):
        raise BadInput(f"{runs} has no run of {', '.join(missing[:5])} ({len(missing)} of {len(listed)} missing)")
    notes += [f"{name} is missing in {runs}: left out" for name in missing]
    return jobs


def _prediction_path(runs: Path, name: str) -> Path | None:
    return next((path for path in (runs / name, runs / f"{name}.txt") if path.exists()), None)


def _draw(result: Evaluation, folder: Path) -> None:
    from app.evaluation.plots import confusion_matrix, precision_recall

    folder.mkdir(parents=True, exist_ok=True)
    for name, content in (
        ("confusion.png", confusion_matrix(result)),
        ("precision_recall.png", precision_recall(result)),
    ):
        if content is not None:
            replace_content(folder / name, content)
