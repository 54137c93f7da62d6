"""Whether a run is still what a library has of it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Literal

from app.library.tables.instance_library import MapEntry
from razer.storage.file_names import FILES, is_map_folder

RunState = Literal["as added", "changed since", "not here"]


def run_state(entry: MapEntry) -> RunState:
    """By the times of its files: "not here" where the folder is no map on this machine, as where it was moved."""
    folder = Path(entry.run)
    if not is_map_folder(folder):
        return "not here"
    return "changed since" if _newest_ns(folder / name for name in FILES) > entry.generation else "as added"


def _newest_ns(files: Iterable[Path]) -> int:
    return max((file.stat().st_mtime_ns for file in files if file.is_file()), default=0)
