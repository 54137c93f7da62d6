"""Atomic creation of a folder: it appears under its name only when everything in it is written."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from razer.errors import BadInput


@contextmanager
def unfinished(folder: Path) -> Iterator[Path]:
    """A hidden folder beside `folder` to write into; it gets its name at the end of the block, and is removed if the
    block raises. Raises BadInput where `folder` exists already."""
    folder = Path(folder).absolute()
    if folder.exists():
        raise BadInput(f"{folder} exists: give a new folder, or remove it first")
    hidden = folder.with_name(f".{folder.name}.unfinished")
    shutil.rmtree(hidden, ignore_errors=True)
    hidden.mkdir(parents=True)
    try:
        yield hidden
    except BaseException:
        shutil.rmtree(hidden, ignore_errors=True)
        raise
    hidden.rename(folder)
