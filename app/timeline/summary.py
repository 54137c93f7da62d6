"""The card of a run: its figures, and what the colours mean."""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np

from razer.arrays import Float64Array

LEGEND = """One colour stands for one instance in map, images and plots; walls, floors and ceilings keep their own, and
have no box. Orange is the way of the camera."""


class RunSummary:
    """Counts frames, the way and the time."""

    def __init__(self) -> None:
        self._start_s = perf_counter()
        self._n_used = self._n_left_out = 0
        self._walked_m = 0.0
        self._last: Float64Array | None = None

    def __getstate__(self) -> dict[str, Any]:
        return vars(self) | {"_start_s": perf_counter() - self._start_s}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state | {"_start_s": perf_counter() - state["_start_s"]})

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
        return (
            f"**{self._n_used}** frames mapped, **{self._n_left_out}** left out, **{fps:.1f}** a second\n\n"
            f"**{n_things}** objects, **{n_surfaces}** walls, floors and the like\n\n"
            f"**{self._walked_m:.1f} m** walked\n\n{LEGEND}"
        )
