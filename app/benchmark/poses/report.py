"""Report of the benchmark of pose estimation: a row for each hard world, over its seeds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

Row = dict[str, Any]
_FAR = 1000


def _values(rows: Sequence[Row], key: str) -> list[float]:
    return [row[key] for row in rows if row[key] is not None]


def _mean(rows: Sequence[Row], key: str) -> str:
    values = _values(rows, key)
    return f"{np.mean(values):.0f}" if values else "-"


def _middle_and_most(rows: Sequence[Row], key: str) -> str:
    """The median, and behind it the worst."""
    values = _values(rows, key)
    if len(values) < 2:
        return _short(values[0]) if values else "-"
    return f"{_short(float(np.median(values)))} ({_short(max(values))})"


def _short(value: float) -> str:
    """Beyond _FAR it does not matter how far."""
    return f"{value:.{1 if value >= 1 else 2}f}" if value < _FAR else f">{_FAR}"


def _tracked(rows: Sequence[Row]) -> str:
    """The mean of the shares, and behind it the least."""
    shares = _values(rows, "share_tracked")
    return f"{100 * np.mean(shares):.0f}" + (f" ({100 * min(shares):.0f})" if len(shares) > 1 else "")


def _shares(rows: Sequence[Row], key: str) -> str:
    """The mean in per cent."""
    return f"{100 * np.mean(_values(rows, key)):.0f}"


def _recovery(rows: Sequence[Row]) -> str:
    """The most frames that a recovery took, and how many runs ended without one."""
    never = sum(row["frames_to_recover"] is None for row in rows)
    longest = max(_values(rows, "frames_to_recover"), default=None)
    told = [] if longest is None else [f"{longest:.0f}"]
    return ", ".join((*told, *([f"never in {never}"] if never else [])))


COLUMNS: dict[str, Callable[[Sequence[Row]], str]] = {
    "tracked %": _tracked,
    "frames to recover": _recovery,
    "false ties": lambda rows: f"{sum(row['false_ties'] for row in rows)}",
    "ATE cm": lambda rows: _middle_and_most(rows, "ate_cm"),
    "turn deg": lambda rows: _middle_and_most(rows, "rotation_deg"),
    "CPU ms": lambda rows: _mean(rows, "cpu_ms"),
    "to fusion": lambda rows: _middle_and_most(rows, "to_plain"),
    "end %": lambda rows: _shares(rows, "end_share"),
    "NEES": lambda rows: _middle_and_most(rows, "nees"),
}
"""What the table says of the runs of one world: shares as mean (least), errors as median (worst) over the seeds."""


def by_world(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """The rows of each world, in the order of the worlds."""
    worlds: dict[str, list[Row]] = {}
    for row in rows:
        worlds.setdefault(row["world"], []).append(row)
    return worlds


def poses_table(rows: Sequence[Row]) -> Table:
    """One line for each world."""
    seeds = list(dict.fromkeys(row["seed"] for row in rows))
    title = f"poses, seeds {', '.join(map(str, seeds))}; tracked: mean (least); errors: median (worst)"
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
    table.add_column("world", no_wrap=True)
    for name in COLUMNS:
        table.add_column(name, justify="right")
    for world, runs in by_world(rows).items():
        table.add_row(world, *(cell(runs) for cell in COLUMNS.values()))
    return table
