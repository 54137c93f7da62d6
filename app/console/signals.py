"""Ctrl-C and SIGTERM as exceptions, but never within an import: compiled modules that are being imported abort the
process, or make some other error of them."""

from __future__ import annotations

import signal
import sys
from threading import Timer, get_ident
from time import monotonic
from types import FrameType

_AGAIN_S, _PATIENCE_S = 0.05, 20.0  # longer than any import takes, for a caller who never leaves one
_IMPORT = "<frozen importlib._bootstrap>"
_first_s: dict[int, float] = {}


def raise_signals() -> None:
    """From now on SIGINT is a KeyboardInterrupt and SIGTERM a SystemExit, so that what is half done is cleaned up."""
    for signum in (signal.SIGINT, signal.SIGTERM):
        signal.signal(signum, _raise_between_imports)


def _raise_between_imports(signum: int, frame: FrameType | None) -> None:
    first_s = _first_s.setdefault(signum, monotonic())
    if _is_importing(frame) and monotonic() - first_s < _PATIENCE_S:
        # To this very thread, as what it may wait for by then has to be cut short.
        again = Timer(_AGAIN_S, signal.pthread_kill, (get_ident(), signum))
        again.daemon = True
        again.start()
        return
    _first_s.pop(signum)
    if signum == signal.SIGINT:
        raise KeyboardInterrupt
    sys.exit(128 + signum)


def _is_importing(frame: FrameType | None) -> bool:
    while frame is not None and frame.f_code.co_filename != _IMPORT:
        frame = frame.f_back
    return frame is not None
