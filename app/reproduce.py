"""`razer reproduce`: a table of the paper, mapped and evaluated anew."""

from __future__ import annotations

from json import dumps
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from app.consoles import progress_console, result_console
from app.options import Flag, RunOptions


def reproduce(
    table: Literal["scenenn", "scannet200", "replica", "scannet", "retrieval"],
    data: Path,
    /,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"])] = Path("reproduced"),
    scenes: str | None = None,
    options: RunOptions = RunOptions(),  # noqa: B008
    json: Flag = False,
) -> int:
    """Map and evaluate every scene of one of the paper's tables, and print our row beside the others.

    Takes up where it was stopped: scenes mapped with the same settings are not mapped again.

    Parameters
    ----------
    table:
        Which table of the paper.
    data:
        The folder with the scenes in their dataset's layout, each with its truth.
    out:
        The folder for a run folder a scene.
    scenes:
        Other scenes than the table's, with commas between.
    json:
        One line of JSON.
    """
    # Late, as in `razer run`.
    from app.evaluation.published import TABLES
    from app.evaluation.reproduction import Reproduction
    from app.evaluation.reproduction_report import report

    wanted = tuple(name.strip() for name in scenes.split(",")) if scenes else ()
    work = Reproduction(TABLES[table], data, out, options, wanted)
    result = work.run(progress_console())
    if json:
        print(dumps(result.as_json(table)))
    else:
        report(result, TABLES[table], result_console())
    return 0
