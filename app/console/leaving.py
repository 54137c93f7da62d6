"""The end of the program, also where a library's threads would never let it end."""

from __future__ import annotations

import os
import sys
from typing import NoReturn

_stuck: set[str] = set()


def note_stuck(library: str) -> None:
    """From now on a library is at work in threads that wait for what will not come, such as room on a full disk."""
    _stuck.add(library)


def leave(code: int) -> NoReturn:
    """End with an exit code; at once where a library is stuck, which Python would wait for."""
    if _stuck:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    sys.exit(code)
