"""`razer reproduce`: reproduction of one of the paper's tables."""

from __future__ import annotations

from dataclasses import replace
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from app.batch.report import REPORT
from app.console.outputs import print_next, print_outputs
from app.console.streams import progress_console, result_console
from app.console.waiting import waiting_for
from app.engines.engine_options import PlacingOptions
from app.next_steps import looking_at
from app.run_folder.folder_lock import writing
from app.settings.options import BOTH, Flag, PosesName, RunOptions
from razer.errors import BadInput

if TYPE_CHECKING:
    from app.reproduction.reproduce_table import Reproduced

OUTPUTS = {"mesh.ply": "the map; a whole run folder", "metrics.json": "its numbers", "timings.json": "its times"}


def reproduce(
    table: Literal["scenenn", "scannet200", "replica", "scannet", "retrieval"],
    data: Path,
    /,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])] = Path("reproduced"),
    scenes: str | None = None,
    placing: PlacingOptions = PlacingOptions(),  # noqa: B008
    options: RunOptions = RunOptions(),  # noqa: B008
    json: Flag = False,
) -> int:
    """Map and evaluate every scene of one of the paper's tables, and print our row beside the others: with --poses slam
    beside the rows under estimated poses, with both once for each. Retrieval and component times come with it.

    The scenes are a batch, see `razer batch run`, and go on where they were stopped. One is mapped after the other, as
    the table has times, unless --workers says how many at once.

    Parameters
    ----------
    table:
        Which table of the paper.
    data:
        The folder with the scenes in their dataset's layout, each with its truth.
    out:
        The folder for a run folder a scene; with --poses both for two folders of them, given and slam.
    scenes:
        Other scenes than the table's, with commas between.
    json:
        One line of JSON.
    """
    with waiting_for("starting"):
        from app.reproduction.published_tables import TABLES
        from app.reproduction.reproduce_table import Reproduction

    scene_names = () if scenes is None else _scene_names(scenes)
    both = options.poses == "both"
    folders: dict[PosesName | None, Path]
    folders = {name: out / name for name in BOTH} if both else {_choice(options): out}
    placing = _one_at_a_time(placing)
    results: dict[PosesName | None, Reproduced] = {}
    for name, folder in folders.items():
        reproduction = Reproduction(TABLES[table], data, folder, replace(options, poses=name), scene_names)
        with writing(folder / REPORT):
            results[name] = reproduction.run(placing, progress_console())
    if json:
        rows = {name: result.as_json(table) | {"poses": name or "auto"} for name, result in results.items()}
        print(dumps(rows if both else rows[next(iter(folders))]))
        return 0
    _report(table, results, folders)
    return 0


def _scene_names(text: str) -> tuple[str, ...]:
    """The scenes that an option lists; raises BadInput for what is no name of a folder, as runs are called so, too."""
    listed = tuple(name.strip() for name in text.split(","))
    if wrong := [name for name in listed if not name or name.startswith(".") or name != Path(name).name]:
        raise BadInput(f"--scenes {text}: '{wrong[0]}' is no name of a scene; give them with commas between")
    return listed


def _one_at_a_time(placing: PlacingOptions) -> PlacingOptions:
    """As asked; on this machine alone, unless asked, so that scenes do not take the time of others."""
    return placing if placing.workers is not None or placing.address is not None else replace(placing, workers=1)


def _choice(options: RunOptions) -> PosesName | None:
    if isinstance(options.poses, Path) or options.poses_from is not None:
        raise BadInput("a table has many recordings, and a file poses one: leave --poses FILE and --poses-from out")
    return options.poses


def _report(table: str, results: dict[PosesName | None, Reproduced], folders: dict[PosesName | None, Path]) -> None:
    """The table of each choice of poses, the files of each scene, and what to do next."""
    from app.reproduction.published_tables import TABLES
    from app.reproduction.report import report

    next_steps = []
    for (name, result), folder in zip(results.items(), folders.values(), strict=True):
        if len(results) > 1:
            result_console().print(f"poses: {name}")
        report(result, TABLES[table], result_console(), name)
        for scene in result.seconds:
            print_outputs(folder / scene, OUTPUTS)
        next_steps.append(looking_at(folder / next(iter(result.seconds))))
    print_next(*next_steps)
