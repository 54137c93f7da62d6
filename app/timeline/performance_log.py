"""What each frame took: stages one upon the other, memory, and the frames that took much longer than most."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.timeline import entities
from app.timeline.recording.rerun_log import Color, RerunLog

CLIP_QUANTILE = 0.99
HEADROOM = 1.1
SLOW_FACTOR = 3.0  # times the median
FEWEST_FRAMES = 10  # before any is called slow
MIN_SHARE = 0.4  # of a slow frame's time, to be its cause alone
# Tableau's ten, and paler ones: colours that are easy to tell apart.
STAGE_COLORS: list[Color] = [
    (31, 119, 180), (255, 127, 14), (44, 160, 44), (214, 39, 40), (148, 103, 189), (140, 86, 75), (227, 119, 194),
    (127, 127, 127), (188, 189, 34), (23, 190, 207), (174, 199, 232), (255, 187, 120), (152, 223, 138),
    (255, 152, 150),
]  # fmt: skip


class PerformanceLog:
    """Logs the milliseconds of each frame."""

    def __init__(self, log: RerunLog) -> None:
        self._log = log
        self._names: list[str] = []
        self._totals: list[float] = []
        self._any_slow = False
        log.marks(entities.SLOW, "slow frame", (214, 39, 40), "Diamond")
        log.series(entities.MEMORY, ["process", "voxels"], STAGE_COLORS[:2])

    def add(self, index: int, stage_ms: Mapping[str, float], process_mb: float, voxels_mb: float) -> None:
        """Log one frame: its milliseconds by stage, and the memory after it."""
        if new := [name for name in stage_ms if name not in self._names]:
            self._names += new
            colors = [STAGE_COLORS[n % len(STAGE_COLORS)] for n in range(len(self._names))]
            self._log.series(entities.STAGES, self._names, colors)
            self._log.legend(entities.STAGE_LEGEND, self._names[::-1], colors[::-1])
        heights = np.cumsum([stage_ms.get(name, 0.0) for name in self._names]).tolist()
        self._log.scalars(entities.STAGES, heights)
        self._log.scalars(entities.MEMORY, [process_mb, voxels_mb])
        self._mark_slow(index, stage_ms)
        self._totals.append(sum(stage_ms.values()))

    def leave_out(self) -> None:
        """A frame was not mapped: the curves break off, as a line across would be made up."""
        for entity in (entities.STAGES, entities.MEMORY):
            self._log.clear(entity, recursive=False)

    def finish(self) -> None:
        """Say so where nothing was slow, so that an empty list is no riddle."""
        if not self._any_slow and self._totals:
            text = f"none took {SLOW_FACTOR:.0f} times the usual {np.median(self._totals):.0f} ms"
            self._log.event(entities.SLOW_EVENTS, text, "INFO")

    def _mark_slow(self, index: int, stage_ms: Mapping[str, float]) -> None:
        total = sum(stage_ms.values())
        usual = float(np.median(self._totals)) if len(self._totals) >= FEWEST_FRAMES else total
        if total <= SLOW_FACTOR * usual:
            return
        self._any_slow = True
        largest = sorted(stage_ms.items(), key=lambda pair: -pair[1])[:2]
        causes = largest[:1] if largest[0][1] >= MIN_SHARE * total else largest
        why = " and ".join(f"{name} {ms:.0f} ms" for name, ms in causes)
        self._log.scalars(entities.SLOW, [min(total, self.clipped_ms or total)])
        self._log.event(entities.SLOW_EVENTS, f"frame {index} took {total:.0f} ms, usually {usual:.0f}: {why}", "INFO")

    @property
    def clipped_ms(self) -> float | None:
        """Where a plot of the frames may end: few take longer; None before there are any."""
        return HEADROOM * float(np.quantile(self._totals, CLIP_QUANTILE)) if self._totals else None
