"""Content-addressed packs of arrays, as version control keeps its objects: what did not change since the last
checkpoint is not written again.

A pack is the bytes of arrays, one after the other. An array is found by the hash of its bytes; where most of a pack is
of no use any more, what is left of it is written anew, so that a folder holds at most about twice of what is needed.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from typing import BinaryIO

from razer.errors import BadInput
from razer.files import opened

SUFFIX = ".pack"
MIN_USED = 0.5  # share of a pack that must be of use, for its arrays to stay where they are
HASH_BYTES = 16


@dataclass(frozen=True, slots=True)
class Place:
    """Where bytes lie: the number of the pack, from which of its bytes on, how many, and their hash."""

    pack: int
    start: int
    length: int
    digest: str


class PackWriter:
    """The packs NAME-N.pack of one process in a folder; each `begin` ... `finish` writes one more."""

    def __init__(self, folder: Path, name: str) -> None:
        self._folder, self._name = folder, name
        self._places: dict[str, Place] = {}  # of all that the last checkpoint needs
        self._worn: set[int] = set()
        self._used: dict[str, Place] = {}
        self._number = max((number_of(path) for path in folder.glob(f"{name}-*{SUFFIX}")), default=-1)
        self._file: BinaryIO | None = None

    def begin(self) -> int:
        """Start the next checkpoint; returns the number of its pack."""
        self._number += 1
        self._used = {}
        kept = Counter[int]()
        for place in self._places.values():
            kept[place.pack] += place.length
        sizes = {pack: pack_path(self._folder, self._name, pack).stat().st_size for pack in kept}
        self._worn = {pack for pack, size in sizes.items() if kept[pack] < MIN_USED * size}
        self._file = pack_path(self._folder, self._name, self._number).open("xb")
        return self._number

    def put(self, data: bytes | memoryview) -> Place:
        """Where the bytes lie: where they were, or in the new pack."""
        digest = blake2b(data, digest_size=HASH_BYTES).hexdigest()
        place = self._used.get(digest) or self._places.get(digest)
        if place is None or place.pack in self._worn:
            assert self._file is not None
            place = Place(self._number, self._file.tell(), len(data), digest)
            self._file.write(data)
        self._used[digest] = place
        return place

    def finish(self) -> list[int]:
        """Close the pack, safe on its disk; the numbers of all packs that the checkpoint needs."""
        assert self._file is not None
        with self._file as file:
            file.flush()
            os.fsync(file.fileno())
        self._file = None
        self._places = self._used
        return sorted({place.pack for place in self._used.values()} | {self._number})

    def abandon(self) -> None:
        """Give up the checkpoint that was begun; the one before stays whole."""
        if self._file is not None:
            with suppress(OSError):  # a full disk does not take what is left in the buffer
                self._file.close()
            self._file = None
            pack_path(self._folder, self._name, self._number).unlink(missing_ok=True)


class PackReader:
    """Reads what lies in the packs of one process."""

    def __init__(self, folder: Path, name: str) -> None:
        self._folder, self._name = folder, name

    def get(self, place: Place) -> bytearray:
        """The bytes; raises BadInput where they are not those that were written."""
        path = pack_path(self._folder, self._name, place.pack)
        try:
            with opened(path) as file:
                file.seek(place.start)
                if not 0 <= place.length <= os.fstat(file.fileno()).st_size - place.start:
                    raise BadInput(f"{path} is cut off: the checkpoint cannot be used")
                data = bytearray(place.length)
                file.readinto(data)
        except BadInput as error:
            raise BadInput(f"{error}; the checkpoint cannot be used") from None
        if blake2b(data, digest_size=HASH_BYTES).hexdigest() != place.digest:
            raise BadInput(f"{path} is damaged: the checkpoint cannot be used")
        return data


def pack_path(folder: Path, name: str, number: int) -> Path:
    """The file of a pack."""
    return folder / f"{name}-{number}{SUFFIX}"


def number_of(path: Path) -> int:
    """The number in the name of a pack, -1 where there is none."""
    number = path.stem.rpartition("-")[2]
    return int(number) if number.isdecimal() else -1


def remove_packs(folder: Path, name: str, kept: Iterable[int]) -> None:
    """Remove the packs before the last of those that are kept which are not; a further one may be under way."""
    needed = {*kept}
    for path in folder.glob(f"{name}-*{SUFFIX}"):
        if number_of(path) not in needed and number_of(path) < max(needed):
            path.unlink(missing_ok=True)
