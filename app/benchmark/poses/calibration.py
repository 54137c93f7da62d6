"""Calibration of covariances: whether the errors of many runs are as large as these say.

Errors of the keyframes of one run go together, and count as one. So the test is over runs: the NEES of one keyframe of
each, summed, is chi-square distributed with 6 degrees of freedom a run where covariances are right."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table
from scipy.stats import chi2

from app.benchmark.poses.consistency import DEGREES_OF_FREEDOM
from razer.arrays import Float64Array

Row = dict[str, Any]
ELLIPSOIDS = (0.5, 0.95)  # probabilities of those that keyframes are counted in
FIGURES = ("nees", "nees_halfway", "nees_last", "share_in_50", "share_in_95")


def nees_figures(nees: Float64Array) -> dict[str, float | None]:
    """FIGURES of a run: the mean NEES (K,) of its keyframes, that of the one halfway through and of the last, and the
    shares that lie in their ellipsoids of 50 and 95 %; None where there is no keyframe."""
    if not len(nees):
        return dict.fromkeys(FIGURES)
    shares = (nees[:, None] <= chi2.ppf(ELLIPSOIDS, DEGREES_OF_FREEDOM)).mean(axis=0)
    values = [nees.mean(), nees[len(nees) // 2], nees[-1], *shares]
    return {name: round(float(value), 3) for name, value in zip(FIGURES, values, strict=True)}


def mean_bounds(n_runs: int) -> tuple[float, float]:
    """Between which the mean NEES over runs, of one keyframe each, lies in 95 of 100 cases if covariances are right."""
    low, high = chi2.ppf((0.025, 0.975), DEGREES_OF_FREEDOM * n_runs) / n_runs
    return float(low), float(high)


def summary(rows: Sequence[Row]) -> Row:
    """What the runs say together: their number, the mean over them of each figure, and the bounds of the mean NEES."""
    known = [row for row in rows if row["nees"] is not None]
    means = {name: round(float(np.mean([row[name] for row in known])), 3) if known else None for name in FIGURES}
    return {"runs": len(known), **means, "bounds": [round(bound, 2) for bound in mean_bounds(max(len(known), 1))]}


def calibration_table(rows: Sequence[Row]) -> Table:
    """A line for each run."""
    table = Table(title="NEES of keyframes; 6 where covariances are right", box=SIMPLE_HEAD, pad_edge=False)
    for name in ("world", "seed", "mean", "halfway", "last", "in 50 %", "in 95 %", "ATE cm"):
        table.add_column(name, justify="left" if name == "world" else "right", no_wrap=True)
    for row in rows:
        table.add_row(row["world"], str(row["seed"]), *(_short(row[name]) for name in (*FIGURES, "ate_cm")))
    return table


def described(means: Row) -> str:
    """What `summary` says, in plain words."""
    low, high = means["bounds"]
    halfway, last, in_half, in_most = (_short(means[name]) for name in FIGURES[1:])
    return (
        f"{means['runs']} runs: mean NEES of the keyframe halfway through {halfway}, of the last {last}; "
        f"right covariances have {low} to {high} in 95 of 100 cases. "
        f"Shares of keyframes in their ellipsoids of 50 %: {in_half}, of 95 %: {in_most}"
    )


def _short(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"
