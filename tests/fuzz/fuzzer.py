"""Changes one file of a valid folder after the other, and notes what ends in anything but a value or one plain line."""

from __future__ import annotations

import os
import random
import resource
import shutil
import signal
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from razer.errors import BadInput
from tests.fuzz.corpus import KINDS, Kind
from tests.fuzz.mutator import mutated

MAX_S = 10  # of the processor
FOR_EVER = 12  # times as long by the clock
MAX_GROWTH_KB = 2**20


@dataclass(frozen=True)
class Finding:
    """What is wrong with how a change ended; `data` is what the file holds then."""

    kind: str
    file: str
    number: int
    problem: str
    data: bytes

    def __str__(self) -> str:
        return f"{self.kind}, change {self.number} of {self.file}: {self.problem}"


class TooSlow(BaseException):
    """No Exception, so that nothing on the way takes it for a damaged file."""


class Fuzzer:
    """The changes of one kind of folder, made in `place`; the number of a change and the seed say what it is."""

    def __init__(self, name: str, place: Path, seed: int) -> None:
        self.name, self.seed, self._place = name, seed, place
        self.kind: Kind = KINDS[name]
        self._valid = place / "valid"
        self.kind.make(self._valid)
        found = (path for pattern in self.kind.changed for path in self._valid.glob(pattern))
        self.files = sorted(path.relative_to(self._valid) for path in found if path.is_file())
        self._contents = [(self._valid / file).read_bytes() for file in self.files]

    def read_valid(self) -> None:
        """Read what is not changed; raises whatever comes of it."""
        self.kind.read(self._valid)

    def finding(self, number: int) -> Finding | None:
        """What is wrong with how a change ends, None = nothing."""
        rng = random.Random(f"{self.seed} {self.name} {number}")
        chosen = rng.randrange(len(self.files))
        file, data = self.files[chosen], mutated(self._contents[chosen], self._contents, rng)
        folder = self._place / "changed" / f"{number}"
        shutil.copytree(self._valid, folder, copy_function=os.link)
        (folder / file).unlink()
        (folder / file).write_bytes(data)
        try:
            problem = _problem(self.kind, folder)
        finally:
            shutil.rmtree(folder)
        return None if problem is None else Finding(self.name, file.as_posix(), number, problem, data)


def _problem(kind: Kind, folder: Path) -> str | None:
    before_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    try:
        with _alarm(MAX_S):
            kind.read(folder)
    except BadInput as error:
        if "\n" in str(error) or not str(error).isprintable():
            return f"more than one line: {error!r}"
        names = {folder.name, *(path.name for path in folder.rglob("*"))}
        if not kind.is_text and not any(name in str(error) for name in names):
            return f"names no file: {error}"
    except TooSlow:
        return f"takes more than {MAX_S} s"
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        return "".join(traceback.format_exception(error)[-4:])
    growth_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before_kb
    return f"takes {growth_kb // 1024} MB" if growth_kb > MAX_GROWTH_KB else None


@contextmanager
def _alarm(seconds: int) -> Iterator[None]:
    """Stop what takes so long of the processor, or waits for ever; other work on the machine counts little."""

    def stop(*_: object) -> None:
        raise TooSlow

    before = {heard: signal.signal(heard, stop) for heard in (signal.SIGPROF, signal.SIGALRM)}
    signal.setitimer(signal.ITIMER_PROF, seconds)
    signal.setitimer(signal.ITIMER_REAL, FOR_EVER * seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.setitimer(signal.ITIMER_REAL, 0)
        for heard, handler in before.items():
            signal.signal(heard, handler)
