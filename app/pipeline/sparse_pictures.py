"""Sparse recordings: all pictures are read and matched at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rich.console import Console

from app.console.progress import show_progress
from app.console.waiting import waiting_for
from app.pipeline.picture_rate import pictures_per_s
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import UnusableFrame
from razer.frame import Frame
from slam.config import SlamConfig
from slam.sparse.sparse_system import SparseSystem


def match_pictures(
    sequence: RgbdSequence,
    indices: Sequence[int],
    config: SlamConfig,
    console: Console,
    see: Callable[[Frame], None] = lambda frame: None,
    skip: Callable[[int, str], None] = lambda index, reason: None,
) -> SparseSystem:
    """Read frames and match them all at once, with progress shown.

    Args:
        sequence: the recording.
        indices: of the frames.
        config: settings of the estimation.
        console: where progress is shown.
        see: is given each frame.
        skip: is given index and reason of each that cannot be used.
    """
    system = SparseSystem(config)
    for index in show_progress(indices, len(indices), lambda: "read", console, things="pictures"):
        try:
            frame = sequence[index]
            system.locate(frame)
        except UnusableFrame as error:
            skip(index, str(error))
            continue
        see(frame)
    with waiting_for("matching the pictures with each other", console):
        system.finish()
    return system


def print_matched(system: SparseSystem, why: str, console: Console) -> None:
    """Say in one line that pictures were matched with each other, why, and how many were located."""
    n_located, n_pictures = len(system.trajectory()), len(system.keyframes)
    console.print(
        f"{why}all pictures were matched with each other, {n_located} of {n_pictures} located; --no-sparse follows the "
        "camera from each to the next",
        soft_wrap=True,
        highlight=False,
    )


def pace(sequence: RgbdSequence, indices: Sequence[int]) -> str:
    """How many pictures a second there are, if it is known, as the beginning of a line."""
    rate = pictures_per_s(sequence, indices)
    return "" if rate is None else f"{rate:.2g} pictures a second: "
