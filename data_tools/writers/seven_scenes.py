"""Writer of the layout of 7-Scenes.

Source: https://www.microsoft.com/en-us/research/project/rgb-d-dataset-7-scenes/
"""

from __future__ import annotations

from pathlib import Path

from data_tools.recordings.sequence import RgbdSequence
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.truth_folder import write_truth
from data_tools.writers.frame_files import frames_to_write, matrix_lines, write_color, write_depth
from data_tools.writers.unfinished import unfinished

UNITS_PER_M = 1000.0
NO_READING = 65535


def write_seven_scenes(
    sequence: RgbdSequence, folder: Path, *, truth: GroundTruth | None = None, lossless: bool = False
) -> list[tuple[int, str]]:
    """Write every usable frame, numbered anew, and return (index, reason) of the others.

    Depth is in millimetres with 65535 where there is none. The layout counts frames and knows no stamps; the camera
    is in camera-intrinsics.txt, a truth in truth/ as in the project's own layout.

    Args:
        sequence: the recording.
        folder: where to; it appears when everything in it is written.
        truth: what is true of the scene; None = nothing is written about it.
        lossless: without effect: colour is always PNG.

    Raises:
        BadInput: where the folder exists, or no frame can be used.
    """
    skipped: list[tuple[int, str]] = []
    with unfinished(folder) as hidden:
        for number, frame in enumerate(frames_to_write(sequence, skipped)):
            name = hidden / f"frame-{number:06d}"
            write_color(name.with_suffix(".color.png"), frame.rgb)
            write_depth(name.with_suffix(".depth.png"), frame.depth, UNITS_PER_M, none=NO_READING)
            if frame.world_from_camera is not None:
                name.with_suffix(".pose.txt").write_text(matrix_lines(frame.world_from_camera))
        (hidden / "camera-intrinsics.txt").write_text(matrix_lines(sequence.intrinsics.matrix))
        if truth is not None:
            write_truth(truth, hidden / "truth")
    return skipped
