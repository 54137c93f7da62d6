"""Why a child process failed, by how it ended and what it said, and what would help."""

from __future__ import annotations

from app.engines.child_process import ChildEnd
from app.engines.task import Remedy

GIVEN_UP = "given up, as the work was ended"
_INTERRUPTED = "it was told to end by a signal from elsewhere"
_MEMORY_WORDS = ("memory ran out", "helper process was ended by the system")
_TRACEBACK = "Traceback (most recent call last)"
_NO_ROOM_WORDS = ("No space left", "free some space", "Disk quota")


def failure(end: ChildEnd, log: str) -> tuple[str, Remedy] | None:
    """Why it failed, and what would help; None where it did not."""
    if end.code == 0:
        return None
    if end.code is None:
        return GIVEN_UP, "elsewhere"
    if end.code == -9:
        return "killed by the system, most often as memory ran out", "memory"
    last = last_words(log)
    if any(words in log[-2000:] for words in _MEMORY_WORDS):
        return last, "memory"
    if end.code in (130, 143):
        return _INTERRUPTED, "elsewhere"
    if end.code == 2:
        return last, "room" if any(words in last for words in _NO_ROOM_WORDS) else "none"
    return (f"ended by signal {-end.code}" if end.code < 0 else f"exit code {end.code}: {last}"), "elsewhere"


def last_words(log: str) -> str:
    """The line that says what went wrong: the last one of a traceback, or the last that is marked as such, without the
    program's name before it."""
    lines = [line.strip() for line in log.splitlines() if line.strip()]
    marks = [n for n, line in enumerate(lines) if line.startswith(("razer: ", "WARNING: ", _TRACEBACK))]
    is_marked = bool(marks) and not lines[marks[-1]].startswith(_TRACEBACK)
    return (lines[marks[-1]] if is_marked else (lines or ["it said nothing"])[-1]).removeprefix("razer: ")
