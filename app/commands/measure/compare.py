"""`razer compare`: comparison of two runs over one recording, most often with given and with estimated poses."""

from __future__ import annotations

from json import dumps
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from app.console.outputs import print_next
from app.console.streams import print_notes, print_warnings, result_console
from app.console.waiting import waiting_for
from app.next_steps import viewing, viewing_both
from app.settings.options import Assignments, Flag, TrustOptions

FOLDER = "compare"


def compare(
    run_a: Path,
    run_b: Path,
    /,
    *,
    truth: Path | None = None,
    preset: str = "default",
    set: Assignments = (),
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    options: TrustOptions = TrustOptions(),  # noqa: B008
    json: Flag = False,
) -> int:
    """Compare two runs over one recording: trajectories, surfaces and instances, B aligned to A.

    Parameters
    ----------
    run_a:
        The run folder to compare with, such as the one with given poses.
    run_b:
        The other run folder, such as the one with estimated poses.
    truth:
        The folder with the ground truth and its camera poses; each run is then evaluated against it too.
    preset:
        Evaluation protocol, as in `razer eval`.
    set:
        One rule of the protocol as name=value; may be repeated.
    out:
        The folder for compare.png, a sheet of all, compare.json, plots and compare.rrd; compare in RUN_B if not given.
    json:
        One line of JSON.
    """
    # Late, since these bring Open3D and torch along.
    with waiting_for("starting"):
        from app.comparison.compare_to_folder import compare_to_folder
        from app.comparison.folder import RECORDING
        from app.comparison.report import report
        from app.evaluation.rules import choose_rules

    rules = choose_rules(preset, set)
    folder = out or run_b / FOLDER
    result = compare_to_folder(run_a, run_b, folder, truth=truth, rules=rules, trust=options.trust)
    print_warnings(result.warnings)
    print_notes(result.notes)
    if json:
        print(dumps(result.as_json()))
    else:
        report(result, result_console(), folder)
        print_next(viewing(folder / RECORDING), *viewing_both(run_a, run_b))
    return 0
