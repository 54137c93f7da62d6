"""`razer eval`: a map, or another system's prediction, measured against the truth."""

from __future__ import annotations

from collections.abc import Iterable
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from app.console.streams import progress_console, result_console
from app.settings.options import Assignments, Flag, TrustOptions
from razer.errors import BadInput
from razer.storage.atomic_files import replace_file

if TYPE_CHECKING:
    from razer.metrics.protocol.evaluation import Evaluation

METRICS = "metrics.json"
PICTURES = "eval"


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
    """Measure instances, classes, surface and poses against the truth.

    Parameters
    ----------
    run:
        A run folder, a submission to the ScanNet benchmark, or a file with a label for each vertex of the truth.
    truth:
        The folder with the truth, or with a recording that holds one; with --scenes the folder that holds them.
    preset:
        Whose rules: default, scannet200, scenenn, hovsg, conceptgraphs, ovo, rayfronts, ovi-map or retrieval.
    set:
        One rule as name=value; may be repeated. The table lists them all.
    names:
        Where a run's instances get their classes: from the run, from the texts of the truth's class names, or
        from the texts where the run has none (auto).
    labels:
        What numbers below 1000 in a file of vertex labels are; from 1000 on they are class * 1000 + instance.
    scene:
        Which scene, where a folder holds several.
    scenes:
        A text file with one scene a line, for many scenes at once: runs are in --runs, truths in --truth.
    runs:
        The folder that holds a run folder (or submission) for each scene.
    strict:
        A missing scene is an error instead of a note.
    out:
        The folder for pictures: confusion matrix and precision over recall; eval in the run folder if not given.
    json:
        One line of JSON.
    """
    # Late, since these bring Open3D and torch along.
    from app.evaluation.evaluate_run import evaluate_jobs
    from razer.storage.map_folder import is_map_folder

    rules = chosen_rules(preset, set)
    notes: list[str] = []
    jobs = _jobs(run, truth, scenes, runs, strict, notes)
    result = evaluate_jobs(jobs, rules, naming=names, scene=scene, labels=labels, trust=options.trust, notes=notes)
    notes += [f"class '{name}' is in no list known here: it counts as no class" for name in result.unknown_names]
    say(notes)
    _deliver(result, run if run is not None and is_map_folder(run) else None, out, json)
    return 0


def _deliver(result: Evaluation, run: Path | None, pictures: Path | None, json: bool) -> None:
    """Numbers and pictures into the run folder, where there is one, and the numbers onto the screen."""
    from app.evaluation.report import report

    content = result.as_json()
    if run is not None:
        write_atomically(run / METRICS, dumps(content, indent=1) + "\n")
        pictures = pictures or run / PICTURES
    if pictures is not None:
        _draw(result, pictures)
    if json:
        print(dumps(content))
    else:
        report(result, result_console(), pictures)


def say(notes: Iterable[str]) -> None:
    """What one should know of a result, on standard error."""
    for note in notes:
        progress_console().print(f"note: {note}", soft_wrap=True)


def chosen_rules(preset: str, assignments: tuple[str, ...]) -> Any:
    """The preset with some of its rules changed; raises BadInput naming what is wrong."""
    import tomllib

    from pydantic import ValidationError

    from razer.metrics.presets import PRESETS

    if preset not in PRESETS:
        raise BadInput(f"no preset '{preset}': choose one of {', '.join(PRESETS)}")
    rules = PRESETS[preset].model_dump()
    for assignment in assignments:
        name, separator, text = (part.strip() for part in assignment.partition("="))
        if not separator or name not in rules:
            raise BadInput(f"--set {assignment}: write rule=value, with one of the rules {', '.join(rules)}")
        try:
            rules[name] = None if text in ("none", "null") else tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError:
            rules[name] = text
    try:
        return type(PRESETS[preset]).model_validate(rules)
    except ValidationError as error:
        first = error.errors()[0]
        raise BadInput(f"--set {first['loc'][0]}: {first['msg']}") from None


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
    jobs = [(name, place, truth / name) for name in listed if (place := _place_of(runs, name)) is not None]
    missing = [name for name in listed if _place_of(runs, name) is None]
    if missing and (strict or not jobs):
        raise BadInput(f"{runs} has no run of {', '.join(missing[:5])} ({len(missing)} of {len(listed)} missing)")
    notes += [f"{name} is missing in {runs}: left out" for name in missing]
    return jobs


def _place_of(runs: Path, name: str) -> Path | None:
    return next((path for path in (runs / name, runs / f"{name}.txt") if path.exists()), None)


def _draw(result: Evaluation, folder: Path) -> None:
    from app.evaluation.plots import confusion_matrix, precision_recall

    folder.mkdir(parents=True, exist_ok=True)
    for name, content in (
        ("confusion.png", confusion_matrix(result)),
        ("precision_recall.png", precision_recall(result)),
    ):
        if content is not None:
            write_atomically(folder / name, content)


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write a file beside its place and rename it, so that it is never seen half written."""
    told = content.encode() if isinstance(content, str) else content
    replace_file(path, lambda part: part.write_bytes(told))
