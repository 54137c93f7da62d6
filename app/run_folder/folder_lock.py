"""Lock of a folder that is being written: one writer at a time, who can be named."""

from __future__ import annotations

import fcntl
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import ELOOP
from pathlib import Path
from types import TracebackType
from typing import IO

from app.console.no_room import NO_ROOM
from razer.errors import BadInput


class FolderLock:
    """As a context: the only writer of a folder, in this and all other processes of the machine.

    The lock is that of the hidden file .NAME.lock beside the folder, which goes with its holder, however that ends; the
    file says which process it is. Where the file cannot be made there is no lock: whoever writes the folder will say
    why it cannot be written.

    Raises BadInput, naming the process, while another one holds it, and OSError where there is no room for a number.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = Path(os.path.abspath(folder))
        if not self._folder.name:
            raise BadInput(f"{self._folder} cannot be written: choose another place with -o")
        self._path = self._folder.with_name(f".{self._folder.name}.lock")
        self._file: IO[bytes] | None = None

    def require_free(self) -> None:
        """Raise BadInput while another process writes the folder."""
        if self._file is None and os.path.lexists(self._path):
            with self:
                pass

    def __enter__(self) -> FolderLock:
        while self._file is None:
            try:
                file = _opened(self._path)
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
        try:
            self._file.truncate(0)
            self._file.write(str(os.getpid()).encode())
        except OSError as error:
            self.__exit__(None, None, None)
            raise OSError(error.errno, error.strerror, str(self._folder)) from None
        return self

    def _is_current(self, file: IO[bytes]) -> bool:
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


def _opened(path: Path) -> IO[bytes]:
    """The file of a lock; raises OSError where it cannot be made, and BadInput where something else is in its place.
    What lies beside a folder may have come with it: through a link, another file would be emptied."""
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK, 0o644)
    except OSError as error:
        if error.errno == ELOOP:
            raise BadInput(f"{path} is a link, where the lock of the folder should be: remove it") from None
        raise
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise BadInput(f"{path} is no file, where the lock of the folder should be: remove it")
    return os.fdopen(descriptor, "r+b", buffering=0)


@contextmanager
def writing(target: Path) -> Iterator[None]:
    """Be the only writer of a file or folder, which other processes are refused while this lasts; folders around it are
    made, and those that were made for nothing go again.

    Raises BadInput, before any work is done, while another process writes it, and where nothing can be written there;
    and where there is no room left for what is written.
    """
    target = Path(os.path.abspath(target))
    if os.path.exists(target) and not (target.is_file() or target.is_dir()):  # Path.exists raises for long names
        raise BadInput(f"{target} is no regular file, and would be replaced by one: choose another place")
    lock, made = FolderLock(target), list[Path]()
    try:
        _make_parents(target, made)
        with lock:
            yield
    except OSError as error:
        if error.errno not in NO_ROOM:
            raise
        why = f"{target} could not be written ({error.strerror})"
        raise BadInput(f"{why}: free some space, or choose another place") from error
    finally:
        for parent in reversed(made):
            with suppress(OSError):  # something is in it
                parent.rmdir()


def require_writable(target: Path) -> None:
    """Raise BadInput, before any work is done, where a target cannot be written, or another process writes it."""
    with writing(target):
        pass


def _make_parents(target: Path, made: list[Path]) -> None:
    """Make the folders around a target, and note which; raises BadInput where they cannot be written to."""
    try:
        for parent in reversed([parent for parent in target.parents if not parent.exists()]):
            parent.mkdir(exist_ok=True)
            made.append(parent)
        if not os.access(target.parent, os.W_OK | os.X_OK):
            raise BadInput(f"{target} cannot be written ({target.parent} is read-only): choose another place")
        _try_file(target)
    except OSError as error:
        raise BadInput(f"{target} cannot be written ({error.strerror}): choose another place") from None


def _try_file(target: Path) -> None:
    """Make an empty file beside a target and remove it; raises OSError. Some file systems allow what they then refuse,
    and what is written has a longer name until it is whole."""
    trial = target.with_name(f".{target.name}.partial-00000000")
    trial.unlink(missing_ok=True)
    os.close(os.open(trial, os.O_WRONLY | os.O_CREAT | os.O_NOFOLLOW, 0o644))
    trial.unlink(missing_ok=True)
