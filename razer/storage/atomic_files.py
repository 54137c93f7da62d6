"""Atomic replacement of files: written beside their place and renamed, so that nobody ever reads half a file."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path


def replace_file(path: Path, writer: Callable[[Path], object]) -> None:
    """Let `writer` write beside the place of a file, under a name with the same ending, and rename it."""
    replace_files({path: writer})


def replace_files(writers: Mapping[Path, Callable[[Path], object]]) -> None:
    """The same for several files, none of which takes its place before all are written; in their order."""
    # Processes that write the same file at the same time, such as two queries of one run, have parts of their own.
    parts = {path: path.with_name(f".part-{os.getpid()}-{path.name}") for path in writers}
    try:
        for path, writer in writers.items():
            # What somebody left there, a link to another file, say, is not written through.
            parts[path].unlink(missing_ok=True)
            with _named_as(path):
                writer(parts[path])
        for path, part in parts.items():
            os.replace(part, path)
    finally:
        for part in parts.values():
            part.unlink(missing_ok=True)


@contextmanager
def _named_as(path: Path) -> Iterator[None]:
    """What the system refuses names the file that is wanted, not the hidden one that is written, or none at all."""
    try:
        yield
    except OSError as error:
        if error.errno is not None:
            error.filename = str(path)
        raise


def replace_content(path: Path, content: str | bytes) -> None:
    """The same with the content of the file: its bytes, or text to be written as UTF-8."""
    data = content.encode() if isinstance(content, str) else content
    replace_file(path, lambda part: part.write_bytes(data))
