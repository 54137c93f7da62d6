"""Writing a recording, and what is true of it, in the project's own folder layout."""

from __future__ import annotations

import shutil
from dataclasses import asdict
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from data_tools.sequence import Sequence
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.truth_folder import write_json, write_objects, write_truth
from razer.frame import BadInput, Frame, UnusableFrame

MILLIMETRES_PER_M = 1000.0
_JPEG_QUALITY = 95


def write_folder(
    sequence: Sequence, folder: Path, *, truth: GroundTruth | None = None, lossless: bool = False
) -> list[tuple[int, str]]:
    """Write every usable frame of a recording, numbered anew, and return (index, reason) of the others.

    Colour becomes JPEG of quality 95, or PNG if lossless; depth 16-bit PNG in millimetres (beyond 65.5 m: none); ids
    16-bit PNG. The folder appears under its name only when complete. Raises BadInput where it exists already."""
    folder = Path(folder)
    if folder.exists():
        raise BadInput(f"{folder} exists: give a new folder, or remove it first")
    unfinished = folder.with_name(f".{folder.name}.unfinished")
    shutil.rmtree(unfinished, ignore_errors=True)
    for part in ("color", "depth"):
        (unfinished / part).mkdir(parents=True)
    skipped = _write_frames(sequence, unfinished, "png" if lossless else "jpg")
    camera = asdict(sequence.intrinsics) | {"depth_scale": MILLIMETRES_PER_M}
    write_json(unfinished / "intrinsics.json", camera)
    if truth is not None:
        write_truth(truth, unfinished / "truth")
    unfinished.rename(folder)
    return skipped


def _write_frames(sequence: Sequence, folder: Path, suffix: str) -> list[tuple[int, str]]:
    skipped: list[tuple[int, str]] = []
    stamps: list[str] = []
    poses: list[str] = []
    classes: dict[int, str] = {}
    for index in range(len(sequence)):
        try:
            frame = sequence[index]
        except UnusableFrame as error:
            skipped.append((index, str(error)))
            continue
        _write_images(frame, folder, f"{len(stamps):06d}", suffix)
        stamps.append(f"{frame.stamp:.6f}")
        classes.update(frame.instance_classes)
        if frame.world_from_camera is not None:
            poses.append(_tum_line(frame.stamp, frame.world_from_camera))
    (folder / "stamps.txt").write_text("".join(f"{stamp}\n" for stamp in stamps))
    if poses:
        (folder / "trajectory.txt").write_text("".join(f"{line}\n" for line in poses))
    if classes:
        write_objects(folder / "truth", classes)
    return skipped


def _write_images(frame: Frame, folder: Path, name: str, suffix: str) -> None:
    color = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2BGR)
    _write_image(folder / "color" / f"{name}.{suffix}", color)
    units = np.rint(frame.depth * MILLIMETRES_PER_M)
    _write_image(folder / "depth" / f"{name}.png", np.where(units < 65535, units, 0).astype(np.uint16))
    if frame.instance_ids is not None:
        if frame.instance_ids.max(initial=0) > 65535:
            raise BadInput(f"frame {frame.index} has instance ids above 65535, which ids/ cannot hold")
        _write_image(folder / "ids" / f"{name}.png", frame.instance_ids.clip(0).astype(np.uint16))


def _write_image(path: Path, image: NDArray) -> None:
    path.parent.mkdir(exist_ok=True)
    options = [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY] if path.suffix == ".jpg" else []
    path.write_bytes(cv2.imencode(path.suffix, image, options)[1].tobytes())


def _tum_line(stamp: float, pose: NDArray[np.float64]) -> str:
    numbers = [*pose[:3, 3], *Rotation.from_matrix(pose[:3, :3]).as_quat()]
    return " ".join([f"{stamp:.6f}", *(f"{x:.9f}" for x in numbers)])
