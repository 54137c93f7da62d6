"""Zip archives within bounds: how many members, how large each is, and how much larger than the archive all are."""

from __future__ import annotations

import lzma
import struct
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from razer.errors import BadInput, one_line
from razer.files.file_bytes import opened

MAX_MEMBERS = 1_000_000  # two for each frame of hours of recording
MAX_MEMBER_BYTES = 256 * 2**20
_UNBOUNDED_RATIO_BYTES = 256 * 2**20  # as much may be compressed as it will
_MAX_RATIO = 100  # beyond that; maps are compressed to a fifth, images hardly
_DAMAGED = (
    zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error,
    OSError, EOFError, RuntimeError, NotImplementedError, ValueError, MemoryError,
)  # fmt: skip


class MissingMember(BadInput):
    """A name that is not in an archive."""


class Archive:
    """A zip archive whose members are read one by one; it stays open, for one process. Raises BadInput."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with opened(path) as file:  # whether it is a file at all
            size = file.seek(0, 2)
        with self._damage("is no zip archive, or a damaged one"):
            self._zip = zipfile.ZipFile(path)
            self._infos = {info.filename: info for info in self._zip.infolist()}
        if len(self._infos) > MAX_MEMBERS:
            raise BadInput(f"{path} has {len(self._infos):,} members where {MAX_MEMBERS:,} are the most: split it")
        unpacked = sum(info.file_size for info in self._infos.values())
        if unpacked > max(_UNBOUNDED_RATIO_BYTES, _MAX_RATIO * size):
            raise BadInput(
                f"{path} would become {unpacked:,} bytes of {size:,}, which is no recording or map: take another file"
            )

    @property
    def names(self) -> tuple[str, ...]:
        """All members."""
        return tuple(self._infos)

    def __contains__(self, name: str) -> bool:
        return name in self._infos

    def __enter__(self) -> Archive:
        return self

    def __exit__(self, *_: object) -> None:
        self._zip.close()

    def size(self, name: str) -> int:
        """Bytes of a member when it is unpacked, as the archive says."""
        if name not in self._infos:
            raise MissingMember(f"{self.path} has no member {name}: it is another kind of file, or not whole")
        return self._infos[name].file_size

    def read(self, name: str, max_bytes: int = MAX_MEMBER_BYTES) -> bytes:
        """The bytes of a member; raises BadInput, also for more than `max_bytes`."""
        if self.size(name) > max_bytes:
            size = f"{self.size(name):,} bytes where {max_bytes:,} are the most"
            raise BadInput(f"{self.path}, member {name} has {size}: take another file")
        with self.opened(name) as member:
            return member.read()

    @contextmanager
    def opened(self, name: str) -> Iterator[IO[bytes]]:
        """A member to be read piece by piece; raises BadInput, also for damage that shows in the block."""
        self.size(name)
        with self._damage(f"is damaged in its member {name}"), self._zip.open(self._infos[name]) as member:
            yield member

    @contextmanager
    def _damage(self, what: str) -> Iterator[None]:
        try:
            yield
        except BadInput:
            raise
        except _DAMAGED as error:
            raise BadInput(f"{self.path} {what} ({one_line(error)}): copy or make it again") from None
