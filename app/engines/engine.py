"""The interface of an engine: what runs tasks."""

from __future__ import annotations

from typing import Protocol

from app.engines.task import Needs, Outcome, Task


class Engine(Protocol):
    """Runs tasks, several at once, each in processes of its own. An attempt is made once: whether there is another one
    is the caller's to decide."""

    @property
    def most(self) -> Needs:
        """The most that one task can be given."""

    def has_room(self, needs: Needs) -> bool:
        """Whether a task with these needs should be submitted now."""

    def submit(self, task: Task) -> None:
        """Begin with a task, now or as soon as there is room."""

    def wait(self, timeout_s: float) -> list[Outcome]:
        """The attempts that ended, as soon as one has; none after the timeout."""

    def close(self) -> None:
        """End what is running, at once; checkpoints stay."""
