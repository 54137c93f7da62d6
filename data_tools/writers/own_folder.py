"""Writer of the project's own folder layout, with the ground truth."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from data_tools.recordings.sequence import RgbdSequence
from data_tools.recordings.trajectories import tum_line
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.truth_folder import write_json, write_objects, write_truth
from data_tools.writers.frame_files import frames_to_write, write_color, write_depth, write_ids, write_parts
from data_tools.writers.unfinished import unfinished
from razer.arrays import Pose
from razer.frame import Frame

MILLIMETRES_PER_M = 1000.0


def write_folder(
    sequence: RgbdSequence, folder: Path, *, truth: GroundTruth | None = None, lossless: bool = False
) -> list[tuple[int, str]]:
    """Write every usable frame of a recording, numbered anew, and return (index, reason) of the others.

    Depth becomes 16-bit PNG in millimetres (beyond 65.5 m: none), ids 16-bit PNG, parts 8-bit PNG.

    Args:
        sequence: the recording.
        folder: where to; it appears when everything in it is written.
        truth: what is true of the scene; None = nothing is written about it.
        lossless: colour as PNG instead of JPEG of quality 95.

    Raises:
        BadInput: where the folder exists, or no frame can be used.
    """
    with unfinished(folder) as hidden:
        for part in ("color", "depth"):
            (hidden / part).mkdir()
        skipped = _write_frames(sequence, hidden, "png" if lossless else "jpg")
        camera = asdict(sequence.intrinsics) | {"depth_scale": MILLIMETRES_PER_M}
        write_json(hidden / "intrinsics.json", camera)
        if truth is not None:
            write_truth(truth, hidden / "truth")
    return skipped


def _write_frames(sequence: RgbdSequence, folder: Path, suffix: str) -> list[tuple[int, str]]:
    skipped: list[tuple[int, str]] = []
    stamped_poses: list[tuple[float, Pose | None]] = []
    classes: dict[int, str] = {}
    for frame in frames_to_write(sequence, skipped):
        _write_images(frame, folder, f"{len(stamped_poses):06d}", suffix)
        stamped_poses.append((frame.stamp, frame.world_from_camera))
        classes.update(frame.instance_classes)
    (folder / "stamps.txt").write_text("".join(f"{stamp:.6f}\n" for stamp, _ in stamped_poses))
    poses = [tum_line(stamp, pose) for stamp, pose in stamped_poses if pose is not None]
    if poses:
        (folder / "trajectory.txt").write_text("".join(f"{line}\n" for line in poses))
    if classes:
        write_objects(folder / "truth", classes)
    return skipped


def _write_images(frame: Frame, folder: Path, name: str, suffix: str) -> None:
    write_color(folder / "color" / f"{name}.{suffix}", frame.rgb)
    write_depth(folder / "depth" / f"{name}.png", frame.depth, MILLIMETRES_PER_M)
    if frame.instance_ids is not None:
        write_ids(folder / "ids" / f"{name}.png", frame)
    if frame.part_ids is not None:
        write_parts(folder / "parts" / f"{name}.png", frame.part_ids)
