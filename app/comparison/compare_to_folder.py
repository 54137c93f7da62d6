"""Comparison of two run folders, written to a folder of its own."""

from __future__ import annotations

from pathlib import Path

from app.comparison.compare_runs import Comparison, compare_runs
from app.comparison.folder import check_folder, write_comparison
from app.console.waiting import waiting_for
from app.run_folder.folder_lock import writing
from razer.metrics.preset import Preset
from razer.plugins import NO_TRUST, Trust


def compare_to_folder(
    run_a: Path, run_b: Path, out: Path, *, truth: Path | None, rules: Preset, trust: Trust = NO_TRUST
) -> Comparison:
    """Compare two runs over one recording, write the comparison and return it.

    Args:
        run_a: the run folder to compare with.
        run_b: the other one, which is aligned to A.
        out: the folder for metrics, plots and the recording; other files in it stay.
        truth: a folder with the truth and its camera poses, which both are evaluated against; None = no truth.
        rules: of the evaluations against the truth.
        trust: which outside code the run folders may name.

    Raises:
        BadInput: where the runs cannot be compared, or `out` cannot be written.
    """
    check_folder(out)
    with writing(out):
        comparison = compare_runs(run_a, run_b, truth, rules, trust)
        with waiting_for("drawing what was compared"):
            write_comparison(comparison, out)
    return comparison
