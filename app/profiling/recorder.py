"""What a run costs: time per stage and frame, memory and map size along the way."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from app.profiling.memory import peak_rss_mb, rss_mb
from razer.stages import measured_by

if TYPE_CHECKING:
    from razer.reintegration.reintegrator import Reintegrator

TENTHS = 10
STAGES = ("decode", "pose", "integrate", "segment", "embed", "lift", "associate", "vote", "maintain", "rebuild", "log")


class Recorder:
    """Collects the figures of timings.json for a run of `frames` frames; `blocks` tells the map's size."""

    def __init__(self, frames: int, blocks: Callable[[], int]) -> None:
        self._frames = frames
        self._blocks = blocks
        self._done = 0
        self._start_s = perf_counter()
        self._stages: dict[str, list[float]] = defaultdict(list)
        self._rss_mb: list[float] = []
        self._n_blocks: list[int] = []

    @contextmanager
    def frame(self, stage_ms: dict[str, float]) -> Iterator[None]:
        """Add the stages within to those already in `stage_ms`, and count the frame."""
        try:
            with timed(stage_ms):
                yield
        finally:
            for name, ms in stage_ms.items():
                self._stages[name].append(ms)
            self._done += 1
            self._sample(TENTHS * self._done // max(self._frames, 1))

    def afterwards(self, steps: Iterator[float]) -> Iterator[float]:
        """Hand on the steps of what is left to do after the last frame, and add the stages within them."""
        done: float | None = 0.0
        while done is not None:
            stage_ms: dict[str, float] = {}
            with timed(stage_ms):
                done = next(steps, None)
            for name, ms in stage_ms.items():
                self._stages[name].append(ms)
            if done is not None:
                yield done

    def rebuilding(self, follower: Reintegrator) -> dict[str, float]:
        """What it cost that the map followed the poses: the share of the run so far, the longest pause, and what
        the kept frames took."""
        ms = self._stages["rebuild"]
        return {
            "share": round(sum(ms) / 1e3 / (perf_counter() - self._start_s), 4),
            "longest_pause_s": round(max(ms, default=0.0) / 1e3, 3),
            "rebuilds": follower.n_rebuilds,
            "replayed_frames": follower.n_replays,
            "stored_frames": follower.n_kept,
            "kb_per_stored_frame": round(follower.stored_bytes / max(follower.n_kept, 1) / 1e3, 1),
        }

    def _sample(self, up_to: int) -> None:
        while len(self._rss_mb) < up_to:
            self._rss_mb.append(round(rss_mb(), 1))
            self._n_blocks.append(self._blocks())

    @property
    def frames_per_s(self) -> float:
        """Frames done in a second since the start."""
        return self._done / (perf_counter() - self._start_s)

    def timings(self) -> dict[str, Any]:
        """The contents of timings.json; a run cut short repeats its last sample in the missing tenths."""
        self._sample(TENTHS)
        wall_s = perf_counter() - self._start_s
        return {
            "format": 1,
            "frames": self._done,
            "wall_s": round(wall_s, 3),
            "fps": round(self._done / wall_s, 3),
            "peak_rss_mb": round(peak_rss_mb(), 1),
            "rss_mb_at_tenths": self._rss_mb,
            "blocks_at_tenths": self._n_blocks,
            "stages": {name: summary(self._stages[name]) for name in sorted(self._stages, key=_place)},
        }


def _place(stage: str) -> int:
    """Where a stage stands in a frame's life, whatever process it ran in; unknown ones come last."""
    return STAGES.index(stage) if stage in STAGES else len(STAGES)


@contextmanager
def timed(stage_ms: dict[str, float]) -> Iterator[None]:
    """Within this context every stage adds its milliseconds to `stage_ms`; one within another is part of that."""

    @contextmanager
    def measure(name: str) -> Iterator[None]:
        start = perf_counter()
        try:
            with measured_by(lambda inner: nullcontext()):
                yield
        finally:
            stage_ms[name] = stage_ms.get(name, 0.0) + 1e3 * (perf_counter() - start)

    with measured_by(measure):
        yield


def summary(ms: list[float]) -> dict[str, float]:
    """Median, 95th percentile (milliseconds) and sum (seconds) of the durations of one stage."""
    median, p95 = np.percentile(ms, [50, 95]) if ms else (0.0, 0.0)
    return {
        "median_ms": round(float(median), 3),
        "p95_ms": round(float(p95), 3),
        "total_s": round(sum(ms) / 1e3, 4),
    }
