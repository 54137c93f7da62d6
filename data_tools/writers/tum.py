"""Writer of the layout of the TUM RGB-D benchmark.

Source: https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats
"""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from data_tools.recordings.sequence import RgbdSequence
from data_tools.recordings.trajectories import tum_line
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.truth_folder import write_json, write_truth
from data_tools.writers.frame_files import frames_to_write, write_color, write_depth
from data_tools.writers.unfinished import unfinished

UNITS_PER_M = 5000.0


def write_tum(
    sequence: RgbdSequence, folder: Path, *, truth: GroundTruth | None = None, lossless: bool = False
) -> list[tuple[int, str]]:
    """Write every usable frame and return (index, reason) of the others.

    rgb/ and depth/ hold PNG files named by their stamp; depth is in 1/5000 m, so that what is beyond 13.1 m becomes
    none. The layout knows neither cameras nor labels: they stand beside it in intrinsics.json and truth/, as in the
    project's own layout.

    Args:
        sequence: the recording.
        folder: where to; it appears when everything in it is written.
        truth: what is true of the scene; None = nothing is written about it.
        lossless: without effect: colour is always PNG.

    Raises:
        BadInput: where the folder exists, or no frame can be used.
    """
    skipped: list[tuple[int, str]] = []
    images, poses = [], []
    with unfinished(folder) as hidden:
        for frame in frames_to_write(sequence, skipped):
            stamp = f"{frame.stamp:.6f}"
            write_color(hidden / "rgb" / f"{stamp}.png", frame.rgb)
            write_depth(hidden / "depth" / f"{stamp}.png", frame.depth, UNITS_PER_M)
            images.append(stamp)
            if frame.world_from_camera is not None:
                poses.append(tum_line(frame.stamp, frame.world_from_camera))
        for part, title in (("rgb", "color images"), ("depth", "depth maps")):
            lines = [f"{stamp} {part}/{stamp}.png" for stamp in images]
            _write_list(hidden / f"{part}.txt", title, sequence.name, "timestamp filename", lines)
        if poses:
            columns = "timestamp tx ty tz qx qy qz qw"
            _write_list(hidden / "groundtruth.txt", "ground truth trajectory", sequence.name, columns, poses)
        write_json(hidden / "intrinsics.json", asdict(sequence.intrinsics) | {"depth_scale": UNITS_PER_M})
        if truth is not None:
            write_truth(truth, hidden / "truth")
    return skipped


def _write_list(path: Path, title: str, name: str, columns: str, lines: list[str]) -> None:
    path.write_text("\n".join([f"# {title}", f"# file: '{name}'", f"# {columns}", *lines]) + "\n")
