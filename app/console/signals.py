"""Ctrl-C and SIGTERM as exceptions, but never within an import: compiled modules that are being imported abort the
process, or make some other error of them; and once more where one is ignored, as in a destructor."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable
from threading import Timer, main_thread
from time import monotonic
from types import FrameType

_AGAIN_S, _PATIENCE_S = 0.05, 20.0  # longer than any import takes, for a caller who never leaves one
_IMPORT = "<frozen importlib._bootstrap>"
_first_s: dict[int, float] = {}


def raise_signals() -> None:
    """From now on SIGINT is a KeyboardInterrupt and SIGTERM a SystemExit, so that what is half done is cleaned up."""
    for signum in (signal.SIGINT, signal.SIGTERM):
        signal.signal(signum, _raise_between_imports)
    if not isinstance(sys.unraisablehook, _RaisedAgain):
        sys.unraisablehook = _RaisedAgain(sys.unraisablehook)


class _RaisedAgain:
    """What becomes of exceptions that nobody can handle where they come up: those of signals are raised once more, a
    little later, all others told as before."""

    def __init__(self, tell: Callable[[sys.UnraisableHookArgs], object]) -> None:
        self._tell = tell

    def __call__(self, ignored: sys.UnraisableHookArgs) -> None:
        if isinstance(ignored.exc_value, KeyboardInterrupt):
            _send_again(signal.SIGINT)
        elif isinstance(ignored.exc_value, SystemExit) and ignored.exc_value.code == 128 + signal.SIGTERM:
            _send_again(signal.SIGTERM)
        else:
            self._tell(ignored)


def _raise_between_imports(signum: int, frame: FrameType | None) -> None:
    first_s = _first_s.setdefault(signum, monotonic())
    if _is_importing(frame) and monotonic() - first_s < _PATIENCE_S:
        _send_again(signum)
        return
    _first_s.pop(signum)
    if signum == signal.SIGINT:
        raise KeyboardInterrupt
    sys.exit(128 + signum)


def _send_again(signum: int) -> None:
    # To the main thread, which handles signals, as what it may wait for by then has to be cut short.
    again = Timer(_AGAIN_S, signal.pthread_kill, (main_thread().ident, signum))
    again.daemon = True
    again.start()


def _is_importing(frame: FrameType | None) -> bool:
    while frame is not None and frame.f_code.co_filename != _IMPORT:
        frame = frame.f_back
    return frame is not None
