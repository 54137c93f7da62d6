"""Lock of a folder that is being written: one writer at a time, who can be named."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path
from types import TracebackType
from typing import BinaryIO

from razer.errors import BadInput


class FolderLock:
    """As a context: the only writer of a folder, in this and all other processes of the machine.

    The lock is that of the hidden file .NAME.lock beside the folder, which goes with its holder, however that ends; the
    file says which process it is. Where the file cannot be made there is no lock: whoever writes the folder will say
    why it cannot be written.

    Raises BadInput, naming the process, while another one holds it.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = Path(os.path.abspath(folder))
        self._path = self._folder.with_name(f".{self._folder.name}.lock")
        self._file: BinaryIO | None = None

    def require_free(self) -> None:
        """Raise BadInput while another process writes the folder."""
        if self._file is None and self._path.exists():
            with self:
                pass

    def __enter__(self) -> FolderLock:
        while self._file is None:
            try:
                file = self._path.open("a+b")
            except OSError:
                return self
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                file.seek(0)
                holder = file.read().decode(errors="replace").strip() or "another one"
                file.close()
                raise BadInput(
                    f"{self._folder} is being written by process {holder}: wait for it, or choose another folder"
                ) from None
            if self._is_current(file):
                self._file = file
            else:  # its holder removed it while we waited
                file.close()
        self._file.truncate(0)
        self._file.write(str(os.getpid()).encode())
        self._file.flush()
        return self

    def _is_current(self, file: BinaryIO) -> bool:
        try:
            return os.path.samestat(os.fstat(file.fileno()), self._path.stat())
        except FileNotFoundError:
            return False

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._file is not None:
            self._path.unlink(missing_ok=True)
            self._file.close()
            self._file = None
