"""The layouts a recording can be written in."""

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
    layout: str, sequence: RgbdSequence, folder: Path, *, truth: GroundTruth | None = None, lossless: bool = False
) -> list[tuple[int, str]]:
    """Write a recording in one of WRITERS and return (index, reason) of each frame that could not be used; raises
    BadInput, also for an unknown layout."""
    if layout not in WRITERS:
        raise BadInput(f"unknown layout '{layout}': choose one of {', '.join(WRITERS)}")
    module, _, function = WRITERS[layout].partition(":")
    write = getattr(import_module(module), function)
    skipped: list[tuple[int, str]] = write(sequence, folder, truth=truth, lossless=lossless)
    return skipped
