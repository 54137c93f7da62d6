"""The layouts a recording can be written in."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from data_tools.sequence import Sequence
from data_tools.truth.ground_truth import GroundTruth
from razer.frame import BadInput
from razer.plugins import load

WRITERS = {
    "own": "data_tools.writers.own_folder:write_folder",
    "tum": "data_tools.writers.tum:write_tum",
    "scenenn": "data_tools.writers.scenenn:write_scenenn",
    "7scenes": "data_tools.writers.seven_scenes:write_seven_scenes",
}


def write_recording(
    layout: str, sequence: Sequence, folder: Path, *, truth: GroundTruth | None = None, lossless: bool = False
) -> list[tuple[int, str]]:
    """Write a recording in one of WRITERS (or "module:function") and return (index, reason) of each frame that could
    not be used; raises BadInput, also for an unknown layout."""
    if layout not in WRITERS and ":" not in layout:
        raise BadInput(f"unknown layout '{layout}': choose one of {', '.join(WRITERS)}")
    options: dict[str, Any] = {"sequence": sequence, "folder": folder, "truth": truth, "lossless": lossless}
    skipped: list[tuple[int, str]] = load("layout", layout, WRITERS, options)
    return skipped
