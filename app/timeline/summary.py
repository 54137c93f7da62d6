"""The card of a run: its figures, and what the colours mean."""

from __future__ import annotations

from time import perf_counter

import numpy as np

from razer.arrays import Float64Array

LEGEND = """
*Map*: its own colours with a little of each instance's; boxes are things, walls and the like have none.
Orange is the way of the camera. The same colour stands for an instance in images, map and plots.

*Objects*: why a thing is one, or two. *Poses*: where the camera was, and was lost. *Performance*: what took long.
"""


class RunSummary:
    """Counts frames, the way and the time."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._start_s = perf_counter()
        self._n_used = self._n_left_out = 0
        self._walked_m = 0.0
        self._last: Float64Array | None = None

    def use(self, position: Float64Array) -> None:
        """A frame was mapped, from this position (3,)."""
        self._n_used += 1
        if self._last is not None:
            self._walked_m += float(np.linalg.norm(position - self._last))
        self._last = position

    def leave_out(self) -> None:
        """A frame was not mapped."""
        self._n_left_out += 1

    def markdown(self, n_things: int, n_surfaces: int) -> str:
        """The card for a map of so many things, and so many walls, floors and the like."""
        fps = self._n_used / max(perf_counter() - self._start_s, 1e-9)
        rows = [
            ("frames mapped", f"{self._n_used}"),
            ("frames left out", f"{self._n_left_out}"),
            ("objects", f"{n_things}"),
            ("walls, floors and the like", f"{n_surfaces}"),
            ("walked", f"{self._walked_m:.1f} m"),
            ("frames a second", f"{fps:.1f}"),
        ]
        table = "\n".join(f"| {name} | {value} |" for name, value in rows)
        return f"**{self._title}**\n\n| | |\n|---|--:|\n{table}\n{LEGEND}"
