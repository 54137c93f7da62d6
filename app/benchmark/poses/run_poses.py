"""The runs of `razer bench poses`: each hard world with each seed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from rich.console import Console

from app.benchmark.poses.followed_walk import follow
from app.benchmark.poses.hard_worlds import WORLDS
from app.console.progress import show_progress
from razer.errors import BadInput
from slam.system import SlamSystem

SEEDS = (1, 2, 3)


def chosen_worlds(names: Sequence[str]) -> list[str]:
    """The worlds by name, each once, or all of them without names; raises BadInput for one that there is not."""
    unknown = [name for name in names if name not in WORLDS]
    if unknown:
        raise BadInput(f"no world '{unknown[0]}': choose from {', '.join(WORLDS)}")
    return list(dict.fromkeys(names or WORLDS))


def measure_poses(
    worlds: Sequence[str], seeds: Sequence[int], n_frames: int | None, console: Console
) -> list[dict[str, Any]]:
    """The figures of each world with each seed, with the keys `world` and `seed`.

    Args:
        worlds: names in WORLDS.
        seeds: of the scenes, of what the sensor does, and of the hand that holds it.
        n_frames: of each walk, at most; None = as many as it usually has.
        console: where progress goes.
    """
    runs = [(world, seed) for world in worlds for seed in seeds]
    rows: list[dict[str, Any]] = []

    def status() -> str:
        world, seed = runs[min(len(rows), len(runs) - 1)]
        return f"{world}, seed {seed}"

    rows_of_runs = _rows(runs, n_frames)
    for row in show_progress(rows_of_runs, len(runs), status, console, first="the first world", things="worlds"):
        rows.append(row)
    return rows


def _rows(runs: Sequence[tuple[str, int]], n_frames: int | None) -> Iterator[dict[str, Any]]:
    for world, seed in runs:
        walk = WORLDS[world].walk(seed, n_frames)
        figures = follow(walk, SlamSystem()).figures(walk.frames_per_s)
        yield {"world": world, "seed": seed, **figures}
