"""When a checkpoint is due: after so many frames, or by time, as far as that costs little."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

EVERY_S = 60.0
MAX_SHARE = 0.03  # of the run's time that checkpoints take, if they go by time


class CheckpointSchedule:
    """Decides when; by time none is due while another one is under way."""

    def __init__(self, every_frames: int | None = None, clock: Callable[[], float] = perf_counter) -> None:
        """`every_frames`: 0 = never, None = every `EVERY_S` seconds, or more rarely where that would take more than
        `MAX_SHARE` of the time."""
        self._every_frames, self._clock = every_frames, clock
        self._is_pending = False
        self._start_s = self._last_s = clock()
        self._spent_s = self._last_cost_s = 0.0

    def is_due(self, n_frames: int) -> bool:
        """Whether to begin one now, after so many frames."""
        if self._every_frames is not None:
            return self._every_frames > 0 and n_frames % self._every_frames == 0
        now_s = self._clock()
        has_room = self._spent_s + self._last_cost_s <= MAX_SHARE * (now_s - self._start_s)
        if self._is_pending or not has_room or now_s - self._last_s < EVERY_S:
            return False
        self._is_pending = True
        return True

    def note_cost(self, cost_s: float) -> None:
        """It is written, which took so long."""
        self._is_pending = False
        self._last_s = self._clock()
        self._spent_s += cost_s
        self._last_cost_s = cost_s
