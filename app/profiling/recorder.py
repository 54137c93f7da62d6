"""Profiling of a run: time per stage and frame, memory and map size along the way."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from time import perf_counter
from typing import TYPE_CHECKING, Any

from app.profiling.map_device import MapDevice
from app.profiling.memory import peak_rss_mb, rss_mb
from app.profiling.stage_summary import stage_summaries
from app.profiling.stage_timer import time_stages

if TYPE_CHECKING:
    from razer.reintegration.reintegrator import Reintegrator

TENTHS = 10
_FIGURES = ("_n_done", "_rss_mb", "_n_blocks", "_device_mb")


class Recorder:
    """Collects the figures of timings.json for a run of `n_frames` frames; `n_blocks` returns the map's size, and its
    voxels live on `device`."""

    def __init__(self, n_frames: int, n_blocks: Callable[[], int], device: MapDevice | None = None) -> None:
        self._n_frames = n_frames
        self._count_blocks = n_blocks
        self._device = device or MapDevice()
        self._n_done = 0
        self._start_s = perf_counter()
        self._stages: dict[str, list[float]] = defaultdict(list)
        self._rss_mb: list[float] = []
        self._n_blocks: list[int] = []
        self._device_mb: list[float] = []

    @property
    def state(self) -> dict[str, Any]:
        """All figures so far; the time is what passed until now."""
        figures = {name: getattr(self, name) for name in _FIGURES}
        return figures | {"wall_s": perf_counter() - self._start_s, "stages": dict(self._stages)}

    @state.setter
    def state(self, state: Mapping[str, Any]) -> None:
        """Go on from the figures of a run that was cut off."""
        for name in _FIGURES:
            setattr(self, name, state[name])
        self._start_s = perf_counter() - state["wall_s"]
        self._stages.update(state["stages"])

    @contextmanager
    def frame(self, earlier_ms: Mapping[str, float]) -> Iterator[dict[str, float]]:
        """Count a frame; gives its milliseconds by stage: those `earlier_ms`, to which the stages within add."""
        try:
            with self.late_frame(earlier_ms) as stage_ms:
                yield stage_ms
        finally:
            self._n_done += 1
            self._sample(TENTHS * self._n_done // max(self._n_frames, 1))

    @contextmanager
    def late_frame(self, earlier_ms: Mapping[str, float]) -> Iterator[dict[str, float]]:
        """The same for a frame that was counted in its turn, when it was lost."""
        with time_stages(earlier_ms, self._device.wait) as stage_ms:
            try:
                yield stage_ms
            finally:
                self._add(stage_ms)

    def afterwards(self, steps: Iterator[float]) -> Iterator[float]:
        """Hand on the steps of what is left to do after the last frame, and add the stages within them."""
        share: float | None = 0.0
        while share is not None:
            with time_stages(wait=self._device.wait) as stage_ms:
                share = next(steps, None)
            self._add(stage_ms)
            if share is not None:
                yield share

    @property
    def frames_per_s(self) -> float:
        """Frames done in a second since the start."""
        return self._n_done / (perf_counter() - self._start_s)

    def timings(self) -> dict[str, Any]:
        """The contents of timings.json; a run cut short repeats its last sample in the missing tenths."""
        self._sample(TENTHS)
        wall_s = perf_counter() - self._start_s
        return {
            "format": 1,
            "frames": self._n_done,
            "wall_s": round(wall_s, 3),
            "fps": round(self._n_done / wall_s, 3),
            "peak_rss_mb": round(peak_rss_mb(), 1),
            "rss_mb_at_tenths": self._rss_mb,
            "blocks_at_tenths": self._n_blocks,
            "device": self._device.name,
            "device_mb_at_tenths": self._device_mb,
            "stages": stage_summaries(self._stages),
        }

    def rebuilding(self, reintegrator: Reintegrator) -> dict[str, float]:
        """The part of timings.json on reintegration: its share of the run so far, the longest pause, and what the kept
        frames took."""
        ms = self._stages["rebuild"]
        return {
            "share": round(sum(ms) / 1e3 / (perf_counter() - self._start_s), 4),
            "longest_pause_s": round(max(ms, default=0.0) / 1e3, 3),
            "rebuilds": reintegrator.n_rebuilds,
            "replayed_frames": reintegrator.n_replays,
            "stored_frames": reintegrator.n_kept,
            "kb_per_stored_frame": round(reintegrator.stored_bytes / max(reintegrator.n_kept, 1) / 1e3, 1),
        }

    def _add(self, stage_ms: Mapping[str, float]) -> None:
        for name, ms in stage_ms.items():
            self._stages[name].append(ms)

    def _sample(self, up_to: int) -> None:
        while len(self._rss_mb) < up_to:
            self._rss_mb.append(round(rss_mb(), 1))
            self._n_blocks.append(self._count_blocks())
            self._device_mb.append(round(self._device.used_mb(), 1))
