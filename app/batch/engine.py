"""The interface of an engine: what runs scenes."""

from __future__ import annotations

from typing import Protocol

from app.batch.scene_task import Needs, Outcome, SceneTask


class Engine(Protocol):
    """Runs scenes, several at once, each as one `razer run`. An attempt is made once: whether there is another one is
    the caller's to decide."""

    @property
    def most(self) -> Needs:
        """The most that one scene can be given."""

    def has_room(self, needs: Needs) -> bool:
        """Whether a scene with these needs should be submitted now."""

    def submit(self, task: SceneTask) -> None:
        """Begin with a scene, now or as soon as there is room."""

    def wait(self, timeout_s: float) -> list[Outcome]:
        """The attempts that ended, as soon as one has; none after the timeout."""

    def close(self) -> None:
        """End what is running, at once; checkpoints stay."""
