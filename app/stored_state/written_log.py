"""What there is of a recording that is being written."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class WrittenLog:
    """The name of a recording, and the sizes of its parts in bytes, by their file names in the order in which they were
    begun."""

    name: str
    sizes: tuple[tuple[str, int], ...]
