"""Checkpoints of the process that reads and locates frames."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.stored_state.saved_state import SavedState
from slam.config import SlamConfig
from slam.poses import GivenPoses

if TYPE_CHECKING:  # torch takes seconds to load, which runs without checkpoints need not wait for
    from app.stored_state.state_codec import KnownObjects
    from app.stored_state.state_files import StateWriter

POSES = "poses"


@dataclass
class PoseCheckpoints:
    """Saves and loads what the locating process holds, in a folder; travels to that process before it is used.
    `slam`: the settings of the estimation, None where poses are given; `resumed`: the state to go on from."""

    folder: Path
    slam: SlamConfig | None
    resumed: SavedState | None = None

    @cached_property
    def _known(self) -> KnownObjects:
        from app.stored_state.state_codec import KnownObjects

        if self.slam is None:
            return KnownObjects.of((), made={GivenPoses: GivenPoses})
        from app.stored_state.pose_state import known_poses  # brings GTSAM along

        return known_poses(self.slam)

    @cached_property
    def _writer(self) -> StateWriter:
        from app.stored_state.state_files import StateWriter

        return StateWriter(self.folder, POSES, self._known)

    def save(self, state: object) -> SavedState:
        """Write the state; raises OSError."""
        return self._writer.save(state)

    def load(self) -> Any:
        """The state to go on from, None where there is none; raises BadInput."""
        if self.resumed is None:
            return None
        from app.stored_state.state_files import load_state

        return load_state(self.folder, self.resumed, self._known)
