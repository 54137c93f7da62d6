"""Edits of a served map."""

from __future__ import annotations

from pathlib import Path


class EditDesk:
    """Where edits of a run go."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def epoch(self) -> int:
        """The number of entries of the log."""
        return 0
