"""Calls that make sense after a verb, by what is there: words after `razer`."""

from __future__ import annotations

import os
from pathlib import Path

from app.console.outputs import Words
from app.run_folder.run_folder import TIMELINE
from app.settings.extra_libraries import can_serve
from app.timeline.viewer.rerun_viewer import DISPLAYS


def looking_at(run: Path) -> Words:
    """How to look at a run here: its timeline in a window or in a browser, its page where it has none."""
    if (run / TIMELINE).exists():
        return viewing(run)
    return "view", run, "--page", run / "map.html"


def viewing(recording: Path) -> Words:
    """How to open a timeline here, in a window or in a browser."""
    has_display = any(os.environ.get(name) for name in DISPLAYS)
    return ("view", recording) if has_display else ("view", recording, "--web")


def viewing_both(run_a: Path, run_b: Path) -> tuple[Words, ...]:
    """How to open the timelines of two runs side by side, where both have one."""
    there = all((run / TIMELINE).exists() for run in (run_a, run_b))
    return (("view", run_a, run_b, *viewing(run_b)[2:]),) if there else ()


def serving(run: Path) -> tuple[Words, ...]:
    """How to serve a run, where its libraries are here."""
    return (("serve", run),) if can_serve() else ()


def mapping(recording: Path, *options: object, beside: bool = False) -> Words:
    """How to map a recording, into a new folder here, or beside it.

    Args:
        recording: a folder or a file.
        options: words that the recording needs, such as --reader NAME.
        beside: whether the run goes beside the recording, which lies where one may write.
    """
    return "run", recording, "-o", new_run(recording, beside=beside), *options


def new_run(recording: Path, *, beside: bool = False) -> Path:
    """A folder for the run of a recording that is not there yet, here or beside it."""
    name = recording.absolute().resolve().stem if recording.is_file() else recording.absolute().resolve().name
    place = recording.parent if beside else Path()
    candidates = (place / f"{name or 'recording'}_run{number}" for number in ("", *range(2, 1000)))
    return next(path for path in candidates if not path.exists())
