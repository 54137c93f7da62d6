"""The end of the program, also where a library's threads would never let it end."""

from __future__ import annotations

import os
import sys
from typing import NoReturn

from app.console.plain_warnings import warn_in_one_line


class EndAtOnce(SystemExit):
    """The end of a process that has no room left, in which the ends of libraries are not to be waited for: short of
    memory or threads, some crash as they are unloaded."""


_stuck: set[str] = set()
_kept: list[object] = []


def note_stuck(library: str, *objects: object) -> None:
    """From now on a library is at work in threads that wait for what will not come, such as room on a full disk. Its
    `objects` are kept, as to let them go would wait, too."""
    _stuck.add(library)
    _kept.extend(objects)


def begin_helper() -> None:
    """To be called in a process of a pool when it begins: its warnings are lines, and it ends at once when its work is
    done and a library is stuck."""
    warn_in_one_line()
    from multiprocessing.util import Finalize  # late: help should not wait for it

    Finalize(None, _end_when_stuck, exitpriority=0)


def _end_when_stuck() -> None:
    if _stuck:
        os._exit(0)


def end_process(ending: SystemExit) -> NoReturn:
    """End as asked; at once where that is asked, or a library is stuck, which Python would wait for. For the process's
    own entry only: whoever calls the program from Python keeps theirs."""
    if (_stuck or isinstance(ending, EndAtOnce)) and isinstance(ending.code, int):
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(ending.code)
    raise ending
