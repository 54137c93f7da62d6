"""Calibration of covariances: whether the errors of many runs are as large as these say.

Errors of the keyframes of one run go together, and count as one. So the test is over runs: the NEES of one keyframe of
each, summed, is chi-square distributed with 6 degrees of freedom a run where covariances are right."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from scipy.stats import chi2

from app.benchmark.poses.consistency import DEGREES_OF_FREEDOM
from razer.arrays import Float64Array

Row = dict[str, Any]
ELLIPSOIDS = (0.5, 0.95)  # probabilities of those that keyframes are counted in


def nees_figures(nees: Float64Array) -> dict[str, float | None]:
    """The mean NEES (K,) of the keyframes of a run, that of the one halfway through and of the last, and the shares
    that lie in their ellipsoids of 50 and 95 %; None where there is no keyframe."""
    inside = [f"share_in_{100 * p:.0f}" for p in ELLIPSOIDS]
    if not len(nees):
        return dict.fromkeys(("nees", "nees_halfway", "nees_last", *inside))
    limits = chi2.ppf(ELLIPSOIDS, DEGREES_OF_FREEDOM)
    shares = (nees[:, None] <= limits).mean(axis=0)
    return {
        "nees": round(float(nees.mean()), 2),
        "nees_halfway": round(float(nees[len(nees) // 2]), 2),
        "nees_last": round(float(nees[-1]), 2),
        **dict(zip(inside, shares.round(3).tolist(), strict=True)),
    }


def mean_bounds(n_runs: int) -> tuple[float, float]:
    """Between which the mean NEES over runs, of one keyframe each, lies in 95 of 100 cases if covariances are right."""
    low, high = chi2.ppf((0.025, 0.975), DEGREES_OF_FREEDOM * n_runs) / n_runs
    return float(low), float(high)


def calibration(rows: Sequence[Row]) -> Row:
    """What the runs say together: their number, the mean over them of each figure, and the bounds of the mean NEES."""
    known = [row for row in rows if row["nees"] is not None]
    names = nees_figures(np.zeros(0))
    means = {name: round(float(np.mean([row[name] for row in known])), 3) if known else None for name in names}
    return {"runs": len(known), **means, "bounds": [round(b, 2) for b in mean_bounds(max(len(known), 1))]}


def print_calibration(rows: Sequence[Row], console: Console) -> None:
    """A line for each run, and what they say together."""
    table = Table(title="NEES of keyframes; 6 where covariances are right", box=SIMPLE_HEAD, pad_edge=False)
    for name in ("world", "seed", "mean", "halfway", "last", "in 50 %", "in 95 %", "ATE cm"):
        table.add_column(name, justify="left" if name == "world" else "right", no_wrap=True)
    for row in rows:
        table.add_row(
            row["world"],
            str(row["seed"]),
            *(_short(row[name]) for name in nees_figures(np.zeros(0))),
            _short(row["ate_cm"]),
        )
    console.print(table)
    together = calibration(rows)
    low, high = together["bounds"]
    console.print(
        f"{together['runs']} runs: mean NEES of the keyframe halfway through {_short(together['nees_halfway'])}, of the "
        f"last {_short(together['nees_last'])}; right covariances have {low} to {high} in 95 of 100 cases",
        soft_wrap=True,
    )
    shares = ", ".join(
        f"{100 * together[f'share_in_{100 * p:.0f}']:.0f} % in those of {100 * p:.0f} %" for p in ELLIPSOIDS
    )
    console.print(f"keyframes in their ellipsoids: {shares}", soft_wrap=True)


def _short(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"
