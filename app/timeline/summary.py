"""The card of a run: what went wrong first, then its figures, and what the colours mean."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from time import perf_counter
from typing import Any

import numpy as np

from razer.arrays import Float64Array

LEGEND = """One colour stands for one instance in map, images and plots; walls, floors and ceilings keep their own, and
have no box. Orange is the way of the camera."""
LOST = "lost"  # how the reason begins where the camera could not be located
MAX_REASONS = 4
MAX_RANGES = 6


class RunSummary:
    """Counts frames, the way and the time."""

    def __init__(self) -> None:
        self._start_s = perf_counter()
        self._n_used = 0
        self._left_out: list[tuple[int, str]] = []
        self._found_late: set[int] = set()
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

    def leave_out(self, frame: int, reason: str) -> None:
        """A frame was not mapped, and why."""
        self._left_out.append((frame, reason))

    def find_late(self, frames: Iterable[int]) -> None:
        """Frames whose cameras are known in the end; of these some were left out in their turn."""
        self._found_late.update(frames)

    def gaps(self) -> list[str]:
        """Markdown: a line for each reason why frames were left out, whatever file it names; the commonest ones."""
        by_kind: dict[str, list[tuple[int, str]]] = {}
        for frame, reason in self._left_out:
            by_kind.setdefault(re.sub(r"\d+", "", reason), []).append((frame, reason))
        commonest = sorted(by_kind.values(), key=lambda stretch: -len(stretch))[:MAX_REASONS]
        return [self._gap(alike) for alike in sorted(commonest)]

    def _gap(self, alike: Sequence[tuple[int, str]]) -> str:
        frames = [frame for frame, _ in alike]
        found = [frame for frame in frames if frame in self._found_late]
        late = f"; {in_ranges(found)} located later" if found else ""
        reason = alike[0][1]
        if reason.startswith(LOST):
            return f"**Camera lost in {in_ranges(frames)}**{late}"
        return f"**Left out: {in_ranges(frames)}**, {reason}{late}"

    def markdown(self, n_things: int, n_surfaces: int, verdicts: Sequence[str] = ()) -> str:
        """The card for a map of so many things, and so many walls, floors and the like; `verdicts` are lines on top."""
        fps = self._n_used / max(perf_counter() - self._start_s, 1e-9)
        figures = (
            f"**{self._n_used}** frames mapped, **{len(self._left_out)}** left out, **{fps:.1f}** a second; "
            f"**{self._walked_m:.1f} m** walked",
            f"**{n_things}** objects, **{n_surfaces}** walls, floors and the like",
            LEGEND,
        )
        return "\n\n".join([*self.gaps(), *verdicts, *figures])


def in_ranges(frames: Sequence[int]) -> str:
    """Frames in words: "frame 7", "frames 50-62, 70", the first few of many ranges."""
    runs: list[list[int]] = []
    for frame in sorted(frames):
        if runs and frame == runs[-1][-1] + 1:
            runs[-1].append(frame)
        else:
            runs.append([frame])
    parts = [f"{run[0]}" if len(run) == 1 else f"{run[0]}-{run[-1]}" for run in runs]
    shown = parts[:MAX_RANGES] + (["..."] if len(parts) > MAX_RANGES else [])
    return f"frame{'s' if len(frames) != 1 else ''} {', '.join(shown)}"
