"""The runs of `razer bench poses`: each hard world with each seed."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from typing import Any

from rich.console import Console

from app.benchmark.poses.calibration_worlds import CALIBRATION_WORLDS
from app.benchmark.poses.followed_walk import follow
from app.benchmark.poses.hard_worlds import WORLDS
from app.console.progress import show_progress
from app.console.waiting import is_live, waiting_for
from razer.errors import BadInput
from slam.sparse.sparse_system import SparseSystem
from slam.system import SlamSystem

_ALL = WORLDS | CALIBRATION_WORLDS


def chosen_worlds(names: Sequence[str], *, calibration: bool = False) -> list[str]:
    """The hard worlds by name, or those for the calibration of covariances, each once, or all of them without names;
    raises BadInput for one that there is not."""
    worlds = CALIBRATION_WORLDS if calibration else WORLDS
    unknown = [name for name in names if name not in worlds]
    if unknown:
        raise BadInput(f"no world '{unknown[0]}': choose from {', '.join(worlds)}")
    return list(dict.fromkeys(names or worlds))


def measure_poses(
    worlds: Sequence[str], seeds: Sequence[int], n_frames: int | None, console: Console
) -> list[dict[str, Any]]:
    """The figures of each world (a name that `chosen_worlds` gave) with each seed, with the keys `world` and `seed`; of
    n_frames of its walk at most, None = as many as it usually has. Progress goes to the console."""
    runs = [(world, seed) for world in worlds for seed in seeds]
    rows: list[dict[str, Any]] = []
    measured = (_measure(world, seed, n_frames, console) for world, seed in runs)
    for row in show_progress(measured, len(runs), lambda: _told(rows), console, first=runs[0][0], things="runs"):
        rows.append(row)
    return rows


def _told(rows: Sequence[dict[str, Any]]) -> str:
    """What was measured last."""
    return f"{rows[-1]['world']}, seed {rows[-1]['seed']}" if rows else ""


def _measure(world: str, seed: int, n_frames: int | None, console: Console) -> dict[str, Any]:
    # A bar goes on by itself; elsewhere one is told every ten seconds what is waited for.
    with nullcontext() if is_live(console) else waiting_for(f"{world}, seed {seed}", console):
        hard = _ALL[world]
        walk = hard.walk(seed, n_frames)
        slam = SparseSystem() if hard.is_sparse else SlamSystem()
        figures = follow(walk, slam).figures(walk.frames_per_s)
    return {"world": world, "seed": seed, **figures}
