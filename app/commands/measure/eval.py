"""`razer eval`: evaluation of a map, or of another system's prediction, against the ground truth."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from app.console.outputs import Words, print_next, print_outputs
from app.console.streams import print_notes, print_warnings, progress_console, result_console
from app.console.waiting import waiting_for
from app.engines.engine_options import EngineOptions
from app.next_steps import looking_at
from app.run_folder import run_folder
from app.run_folder.folder_lock import writing
from app.settings.options import Assignments, Flag, TrustOptions
from razer.errors import BadInput
from razer.files import read_lines
from razer.storage.atomic_files import replace_content

if TYPE_CHECKING:
    from rich.console import Console

    from app.evaluation.export import Export
    from razer.metrics.protocol.evaluation import Evaluation

PLOTS = "eval"
MAP_PICTURE = "map.png"
PICTURES = {
    MAP_PICTURE: "the map by what became of its instances",
    "confusion.png": "which classes were taken for which",
    "precision_recall.png": "precision over recall, by IoU",
}


@Parameter(name="*")
@dataclass(frozen=True)
class SceneListOptions:
    """Many scenes, evaluated together."""

    scenes: Path | None = None
    """A text file with one scene a line, for many scenes at once: runs are in --runs, truths in --truth."""
    runs: Path | None = None
    """The folder that holds a run folder (or submission) for each scene."""
    strict: Flag = False
    """A missing scene is an error instead of a note."""

    def jobs(self, run: Path | None, truth: Path, notes: list[str]) -> list[tuple[str, Path, Path]]:
        """(name, prediction, truth folder) of the run or all scenes listed; notes those missing; raises BadInput."""
        if self.scenes is None:
            if run is None:
                raise BadInput("give a run to evaluate, or --scenes LIST with --runs DIR")
            return [(run.absolute().name, run, truth)]
        if run is not None or self.runs is None:
            raise BadInput("--scenes LIST needs --runs DIR and no single run")
        predictions = [(name, _prediction_path(self.runs, name)) for name in _listed(self.scenes)]
        jobs = [(name, path, truth / name) for name, path in predictions if path is not None]
        missing = [name for name, path in predictions if path is None]
        if missing and (self.strict or not jobs):
            counts = f"{len(missing)} of {len(predictions)} missing"
            raise BadInput(f"{self.runs} has no run of {', '.join(missing[:5])} ({counts})")
        notes += [f"{name} is missing in {self.runs}: left out" for name in missing]
        return jobs


@Parameter(name="*")
@dataclass(frozen=True)
class ReadingOptions:
    """How predictions are read."""

    names: Literal["auto", "run", "text"] = "auto"
    """Where a run's instances get their classes: from the run; by text, from the truth's class names; or by text only
    if the run has none (auto)."""
    labels: Literal["instance", "class"] = "instance"
    """Meaning of numbers below 1000 in a file of vertex labels; from 1000 on they are class * 1000 + instance."""
    scene: str | None = None
    """Which scene, where a folder holds several."""


@Parameter(name="*")
@dataclass(frozen=True)
class ExportOptions:
    """What is evaluated, written for other tools."""

    export: Annotated[tuple[Literal["scannet", "replica", "labels"], Path] | None, Parameter(negative="")] = None
    """Write what is evaluated as a format, and into a folder: scannet, a submission to its benchmark; replica, texts
    with the class and the instance of each vertex; labels, a mesh with both."""

    def of(self, scene: str | None) -> Export | None:
        """Where it goes; scene: what files are called, None = as each scene is. Raises BadInput where the one is no
        folder, or the other would lead out of it."""
        from app.evaluation.export import Export

        if self.export is None:
            return None
        kind, folder = self.export
        if folder.exists() and not folder.is_dir():
            raise BadInput(f"--export {kind} {folder}: that is a file, give a folder")
        if scene is not None and scene != Path(scene).name:
            raise BadInput(f"--scene {scene}: exported files are called by it, so it must be a plain name")
        return Export(kind, folder, scene=scene)


def _listed(scenes: Path) -> list[str]:
    """The scenes of a list; raises BadInput for none, and for one that is there twice, as it would count twice."""
    listed = [line.strip() for line in read_lines(scenes) if line.strip()]
    if not listed:
        raise BadInput(f"{scenes} lists no scene: give one a line")
    twice = [name for name, count in Counter(listed).items() if count > 1]
    if twice:
        raise BadInput(f"{scenes} lists {twice[0]} {listed.count(twice[0])} times: leave all but one out")
    return listed


def _prediction_path(runs: Path, name: str) -> Path | None:
    return next((path for path in (runs / name, runs / f"{name}.txt", runs / f"{name}.ply") if path.exists()), None)


def evaluate(
    run: Path | None = None,
    /,
    *,
    truth: Path,
    preset: str = "default",
    set: Assignments = (),
    reading: ReadingOptions = ReadingOptions(),
    scene_list: SceneListOptions = SceneListOptions(),
    export_options: ExportOptions = ExportOptions(),
    engine: EngineOptions = EngineOptions(),  # noqa: B008
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
        Evaluation protocol, which also says what class numbers in files mean: default, scannet200, scannet20, scenenn,
        hovsg, conceptgraphs, ovo, rayfronts, ovi-map or retrieval.
    set:
        One rule of the protocol as name=value; may be repeated.
    out:
        The folder for plots: confusion matrix, precision-recall curves and, of a run, the map by what became of its
        instances; eval in the run folder if not given.
    json:
        One line of JSON.
    """
    # Late, since these bring Open3D and torch along.
    with waiting_for("starting"):
        from app.evaluation.evaluate_run import Reading
        from app.evaluation.evaluate_scenes import evaluate_scenes
        from app.evaluation.rules import choose_rules

    rules = choose_rules(preset, set)
    notes: list[str] = []
    jobs = scene_list.jobs(run, truth, notes)
    export = export_options.of(None if scene_list.scenes else reading.scene or _scene_of(truth))
    read_as = Reading(reading.names, reading.scene, reading.labels, options.trust, export)
    with _written(run, out) as evaluated:
        result = evaluate_scenes(jobs, rules, read_as, engine.engine, progress_console(), notes=notes)
        _deliver(result, jobs, notes, evaluated, out, json)
    return 0


@contextmanager
def _written(run: Path | None, pictures: Path | None) -> Iterator[Path | None]:
    """Where it cannot be written what is written, raise BadInput before the work; the run folder, if it is one."""
    from razer.storage.file_names import is_map_folder

    with ExitStack() as files:
        if run is not None and not is_map_folder(run):
            run = None
        if run is not None:
            files.enter_context(writing(run / run_folder.METRICS))
            pictures = pictures or run / PLOTS
        if pictures is not None:
            if pictures.exists() and not pictures.is_dir():
                raise BadInput(f"-o {pictures}: that is a file, give a folder for the plots")
            files.enter_context(writing(pictures))
        yield run


def _scene_of(truth: Path) -> str:
    """What a scene is called: as the folder of its truth, or the one around a folder `truth`."""
    folder = truth.absolute()
    return folder.parent.name if folder.name == "truth" else folder.name


def _deliver(
    result: Evaluation,
    jobs: list[tuple[str, Path, Path]],
    notes: list[str],
    run: Path | None,
    pictures: Path | None,
    json: bool,
) -> None:
    """Print notes, write metrics and plots into the run folder, if there is one, and print the metrics."""
    from app.evaluation.frame_accounts import with_accounts
    from app.evaluation.report import report

    print_warnings(result.warnings)
    print_notes(notes)
    print_notes(f"ATE: positions hardly align: {cause}" for cause in (result.pose or {}).get("degenerate", ()))
    if names := result.unknown_names:
        print_notes([f"not among the classes of this preset, so of no class: {', '.join(names)}"])
    content = with_accounts(result.as_json(), [(name, prediction) for name, prediction, _ in jobs])
    if run is not None:
        replace_content(run / run_folder.METRICS, dumps(content, indent=1) + "\n")
        pictures = pictures or run / PLOTS
    if pictures is not None:
        with waiting_for("drawing plots"):
            _draw(result, pictures)
    if json:
        print(dumps(content))
    else:
        report(result, result_console())
    if run is not None and pictures is not None:
        with waiting_for("drawing the map"):
            _draw_map(result, run, pictures / MAP_PICTURE, progress_console() if json else result_console())
    if not json:
        _tell_outputs(run, pictures)
        print_next(*_next_steps(jobs, run))


def _tell_outputs(run: Path | None, pictures: Path | None) -> None:
    if run is not None:
        print_outputs(run, {run_folder.METRICS: "all numbers"})
    if pictures is not None:
        print_outputs(pictures, PICTURES)


def _next_steps(jobs: list[tuple[str, Path, Path]], run: Path | None) -> list[Words]:
    """To look at a run that was evaluated, or at a scene of many by itself."""
    if run is not None:
        return [looking_at(run)]
    name, prediction, truth = jobs[0]
    if len(jobs) > 1:
        return [("eval", prediction, "--truth", truth, "-o", f"{name}_eval")]
    return [("inspect", truth)]


def _draw(result: Evaluation, folder: Path) -> None:
    from app.evaluation.plots import confusion_matrix, precision_recall

    folder.mkdir(parents=True, exist_ok=True)
    for name, content in (
        ("confusion.png", confusion_matrix(result)),
        ("precision_recall.png", precision_recall(result)),
    ):
        if content is not None:
            replace_content(folder / name, content)


def _draw_map(result: Evaluation, run: Path, target: Path, console: Console) -> None:
    """The map of a run by what became of its instances, where it was evaluated by instances."""
    from app.evaluation.outcome_picture import outcome_scene
    from app.pictures.picture_file import add_picture
    from razer.saved_map import load_map

    (outcomes,) = result.scenes.values()
    if outcomes["matches"] or outcomes.get("n_predicted"):
        add_picture(target, outcome_scene(load_map(run), outcomes), console)
