"""The runs of `razer bench poses`: each hard world with each seed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from typing import Any

from rich.console import Console

from app.benchmark.poses.followed_walk import follow
from app.benchmark.poses.worlds.hard_worlds import HardWorld
from app.console.progress import show_progress
from app.console.waiting import is_live, waiting_for
from razer.errors import BadInput
from slam.sparse.sparse_system import SparseSystem
from slam.system import SlamSystem


def chosen_worlds(names: Sequence[str], worlds: Mapping[str, HardWorld]) -> dict[str, HardWorld]:
    """Worlds by name, each once, or all of them without names; raises BadInput for one that there is not."""
    unknown = [name for name in names if name not in worlds]
    if unknown:
        raise BadInput(f"no world '{unknown[0]}': choose from {', '.join(worlds)}")
    return {name: worlds[name] for name in names or worlds}


def measure_poses(
    worlds: Mapping[str, HardWorld], seeds: Sequence[int], n_frames: int | None, console: Console
) -> list[dict[str, Any]]:
    """The figures of each world with each seed, with the keys `world` and `seed`; of n_frames of its walk at most, None
    = as many as it usually has. Progress goes to the console."""
    runs = [(world, seed) for world in worlds for seed in seeds]
    rows: list[dict[str, Any]] = []
    measured = (_measure(name, worlds[name], seed, n_frames, console) for name, seed in runs)
    for row in show_progress(measured, len(runs), lambda: _told(rows), console, first=runs[0][0], things="runs"):
        rows.append(row)
    return rows


def _told(rows: Sequence[dict[str, Any]]) -> str:
    """What was measured last."""
    return f"{rows[-1]['world']}, seed {rows[-1]['seed']}" if rows else ""


def _measure(name: str, world: HardWorld, seed: int, n_frames: int | None, console: Console) -> dict[str, Any]:
    # A bar goes on by itself; elsewhere one is told every ten seconds what is waited for.
    with nullcontext() if is_live(console) else waiting_for(f"{name}, seed {seed}", console):
        walk = world.walk(seed, n_frames)
        slam = SparseSystem() if world.is_sparse else SlamSystem()
        figures = follow(walk, slam).figures(walk.frames_per_s)
    return {"world": name, "seed": seed, **figures}
