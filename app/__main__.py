"""The process of one command, from its first import to its end."""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType
from typing import NoReturn


def program() -> NoReturn:
    """Run the command line and end as it says; at once where a library's threads would keep Python from ending."""
    signal.signal(signal.SIGINT, _end_quietly)  # imports take a while, and nothing is begun that could be finished
    from app.cli import BAD_INPUT, main
    from app.console.leaving import end_process

    try:
        main()
    except SystemExit as ending:
        if ending.code == BAD_INPUT:
            sys.unraisablehook = lambda _: None  # what libraries left half-made for want of room complains as it goes
        end_process(ending)


def _end_quietly(signum: int, frame: FrameType | None) -> None:
    os._exit(128 + signum)


if __name__ == "__main__":
    program()
