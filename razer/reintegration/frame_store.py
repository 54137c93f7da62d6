"""Frame store with spilling: packed frames in memory, and beyond a limit in one temporary file that goes with the
process, however it ends."""

from __future__ import annotations

from tempfile import TemporaryFile
from typing import IO, Any
from weakref import finalize


class FrameStore:
    """A list of byte strings that holds at most `memory_limit_bytes` of them in memory."""

    def __init__(self, memory_limit_bytes: int) -> None:
        self._limit = memory_limit_bytes
        self._in_memory: list[bytes] = []
        self._spans: list[tuple[int, int]] = []  # start and length of what was written to the file
        self._file: IO[bytes] | None = None
        self.memory_bytes = 0

    def __getstate__(self) -> dict[str, Any]:
        return {"memory_limit_bytes": self._limit, "packed": [self[i] for i in range(len(self))]}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(state["memory_limit_bytes"])  # type: ignore[misc]
        for packed in state["packed"]:
            self.append(packed)

    def __len__(self) -> int:
        return len(self._in_memory) + len(self._spans)

    @property
    def spilled_bytes(self) -> int:
        """Bytes in the temporary file."""
        return sum(self._spans[-1]) if self._spans else 0

    def append(self, packed: bytes) -> None:
        """Keep one more frame; once the limit is reached, all further ones are written to the file."""
        if not self._spans and self.memory_bytes + len(packed) <= self._limit:
            self._in_memory.append(packed)
            self.memory_bytes += len(packed)
            return
        if self._file is None:
            # Without a name from the start, so that not even a kill leaves it behind.
            self._file = TemporaryFile(prefix="razer-frames-")  # noqa: SIM115
            finalize(self, self._file.close)
        self._file.seek(start := self.spilled_bytes)
        self._file.write(packed)
        self._spans.append((start, len(packed)))

    def __getitem__(self, i: int) -> bytes:
        if i < len(self._in_memory):
            return self._in_memory[i]
        start, length = self._spans[i - len(self._in_memory)]
        assert self._file is not None
        self._file.seek(start)
        return self._file.read(length)
