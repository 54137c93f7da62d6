"""Registry of dataset writers: the layouts a recording can be written in."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from data_tools.recordings.sequence import RgbdSequence
from data_tools.truth.ground_truth import GroundTruth
from razer.errors import BadInput

WRITERS = {
    "own": "data_tools.writers.own_folder:write_folder",
    "scannet": "data_tools.writers.scannet:write_scannet",
    "sens": "data_tools.writers.scannet:write_scannet_sens",
    "replica": "data_tools.writers.replica:write_replica",
    "tum": "data_tools.writers.tum:write_tum",
    "scenenn": "data_tools.writers.scenenn:write_scenenn",
    "7scenes": "data_tools.writers.seven_scenes:write_seven_scenes",
}


def write_recording(
    sequence: RgbdSequence,
    folder: str | Path,
    layout: str = "own",
    *,
    truth: GroundTruth | None = None,
    lossless: bool = False,
) -> list[tuple[int, str]]:
    """Write a recording in one of the layouts of WRITERS and return (index, reason) of each frame that cannot be used.

    Args:
        sequence: the recording.
        folder: where to; it appears when everything in it is written.
        layout: a name in WRITERS.
        truth: what is true of the scene; None = nothing is written about it.
        lossless: colour as PNG where the layout would have JPEG.

    Raises:
        BadInput: for an unknown layout, a folder that exists, or a recording without a usable frame.
    """
    if layout not in WRITERS:
        raise BadInput(f"unknown layout '{layout}': choose one of {', '.join(WRITERS)}")
    module, _, function = WRITERS[layout].partition(":")
    write = getattr(import_module(module), function)
    skipped: list[tuple[int, str]] = write(sequence, Path(folder), truth=truth, lossless=lossless)
    return skipped
