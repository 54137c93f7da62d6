"""A function called in a process of its own, whose result comes back by a file.

python -m app.engines.called_function CALL RESULT
"""

from __future__ import annotations

import pickle
import socket
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event
from time import monotonic
from typing import Any

from app.console.no_room import no_room_line
from app.console.plain_warnings import warn_in_one_line
from app.engines.child_failure import GIVEN_UP, failure
from app.engines.child_notes import notes_of
from app.engines.child_process import ChildEnd, run_child
from app.engines.task import Needs, Outcome
from razer.errors import BadInput

LOG_BYTES = 64_000


@dataclass(frozen=True)
class Call:
    """A function of a module, with arguments, all of which can be pickled."""

    function: Callable[..., Any]
    arguments: tuple[Any, ...]

    def run(
        self, scratch: Path, *, folder: str, cores: int, threads: int, stop: Event
    ) -> tuple[ChildEnd, str, bytes | None]:
        """Call it, as `run_child` takes the rest: how that ended, what it said, and the pickled result."""
        call, result, log = (scratch / name for name in ("call", "result", "call-log"))
        call.write_bytes(pickle.dumps(self))
        command = [sys.executable, "-m", "app.engines.called_function", str(call), str(result)]
        end = run_child(command, log, scratch / "out", folder=folder, cores=cores, threads=threads, stop=stop)
        said = log.read_bytes()[-LOG_BYTES:].decode(errors="replace")
        return end, said, result.read_bytes() if end.code == 0 else None


@dataclass(frozen=True)
class CallTask:
    """One attempt at a call, see `Task`. working_folder: what relative paths in its arguments are relative to."""

    name: str
    call: Call
    needs: Needs
    working_folder: str
    number: int = 1
    avoid: str = ""

    def run(self, stop: Event) -> Outcome:
        """Call the function."""
        begun_s = monotonic()
        with TemporaryDirectory(prefix="razer-call-") as scratch:
            end, log, result = self.call.run(
                Path(scratch), folder=self.working_folder, cores=0, threads=max(1, int(self.needs.cpus)), stop=stop
            )
        outcome = Outcome(self.name, cpu_s=end.cpu_s, peak_mb=end.peak_mb, log=log, notes=notes_of(log), result=result)
        outcome = replace(outcome, seconds=monotonic() - begun_s, node=socket.gethostname())
        if stop.is_set():
            return replace(outcome, reason=GIVEN_UP, remedy="elsewhere")
        reason, remedy = failure(end, log) or ("", "none")
        return replace(outcome, reason=reason, remedy=remedy)


def main() -> None:
    """Call it; exit code 2 and a line for what cannot be used, and where there is no room, as the program has it."""
    warn_in_one_line()
    call, result = map(Path, sys.argv[1:])
    try:
        asked: Call = pickle.loads(call.read_bytes())
        value = asked.function(*asked.arguments)
    except Exception as error:
        if (line := str(error) if isinstance(error, BadInput) else no_room_line(error)) is None:
            raise
        print(f"razer: {line}", file=sys.stderr)
        sys.exit(2)
    result.write_bytes(pickle.dumps(value))


if __name__ == "__main__":
    main()
