"""Waiting for a helper process: not after a stop is requested, and not in silence."""

from __future__ import annotations

from typing import Protocol

from rich.console import Console


class Stop(Protocol):
    """Whether what goes on is to end early."""

    requested: bool


class HelperWait:
    """Says what is waited for, on a console, after 5 seconds and now and then after that."""

    def __init__(self, stop: Stop | None = None, console: Console | None = None) -> None:
        self._stop, self._console = stop, console
        self.told_after_s: tuple[float, ...] = (5.0, 30.0, 120.0, 600.0)
        self._n_told = 0

    @property
    def is_over(self) -> bool:
        """Whether to wait no more."""
        return self._stop is not None and self._stop.requested

    def begin(self) -> None:
        """A wait begins."""
        self._n_told = 0

    def go_on(self, waited_s: float, what: str) -> None:
        """It lasts for so long by now; `what` is waited for."""
        if (
            self._console is None
            or self._n_told == len(self.told_after_s)
            or waited_s < self.told_after_s[self._n_told]
        ):
            return
        self._n_told = sum(waited_s >= limit for limit in self.told_after_s)
        told = f"waiting for {what}: {waited_s:.0f} s so far (Ctrl-C saves what was mapped)"
        self._console.print(told, soft_wrap=True)
