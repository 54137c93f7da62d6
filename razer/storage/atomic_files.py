"""Crash-safe writing: a file takes its place when it is complete."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path


def replace_file(path: Path, writer: Callable[[Path], object]) -> None:
    """Let `writer` write beside the place of a file, under a name with the same ending, and rename it."""
    replace_files({path: writer})


def replace_files(writers: Mapping[Path, Callable[[Path], object]]) -> None:
    """The same for several files, none of which takes its place before all are written; in their order."""
    parts = {path: path.with_name(f".part-{path.name}") for path in writers}
    try:
        for path, writer in writers.items():
            writer(parts[path])
        for path, part in parts.items():
            os.replace(part, path)
    finally:
        for part in parts.values():
            part.unlink(missing_ok=True)
