"""Writer of ScanNet scenes, extracted or as a .sens file, with the ground truth.

Sources: SensReader and the list of files in https://github.com/ScanNet/ScanNet, the metadata file in
http://scan-net.org/ScanNet/ScannerApp
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from data_tools.recordings.sequence import RgbdSequence
from data_tools.truth.ground_truth import GroundTruth
from data_tools.writers.frame_files import frames_to_write, matrix_lines, write_color, write_depth
from data_tools.writers.scannet_truth import write_scannet_truth
from data_tools.writers.sens_file import write_sens_file
from data_tools.writers.unfinished import unfinished
from razer.frame import Frame, Intrinsics

UNITS_PER_M = 1000.0
_UNKNOWN_POSE = np.full((4, 4), -np.inf)


def write_scannet(
    sequence: RgbdSequence,
    folder: Path,
    *,
    truth: GroundTruth | None = None,
    lossless: bool = False,
    sens: bool = False,
) -> list[tuple[int, str]]:
    """Write every usable frame, numbered anew from 0, and return (index, reason) of the others.

    The frames become color/0.jpg (.png if lossless), depth/0.png in millimetres (beyond 65.5 m: none), pose/0.txt
    (-inf where one is unknown) and intrinsic/, or one .sens file, which keeps stamps. The scene is called as the
    folder. Colour is written as it comes, on the grid of depth. A truth becomes mesh, segments, aggregation and label
    map.

    Args:
        sequence: the recording.
        folder: where to; it appears when everything in it is written.
        truth: what is true of the scene; None = nothing is written about it.
        lossless: colour as PNG instead of JPEG.
        sens: one .sens file named by the scene instead of image files.

    Raises:
        BadInput: where the folder exists, or no frame can be used.
    """
    scene, suffix = Path(folder).name, ".png" if lossless else ".jpg"
    skipped: list[tuple[int, str]] = []
    with unfinished(folder) as hidden:
        frames, camera = frames_to_write(sequence, skipped), sequence.intrinsics
        if sens:
            path = hidden / f"{scene}.sens"
            options = {"sensor": sequence.name, "suffix": suffix}
            count = write_sens_file(path, frames, camera, units_per_metre=UNITS_PER_M, **options)
        else:
            count = _write_folders(hidden, frames, suffix, has_poses=sequence.has_poses)
            _write_matrices(hidden / "intrinsic", camera)
        (hidden / f"{scene}.txt").write_text(_metadata(camera, count))
        if truth is not None:
            write_scannet_truth(truth, hidden, scene)
    return skipped


def write_scannet_sens(
    sequence: RgbdSequence, folder: Path, *, truth: GroundTruth | None = None, lossless: bool = False
) -> list[tuple[int, str]]:
    """Write a scene with a .sens file, as write_scannet does, and return (index, reason) of frames that cannot be used.

    Args:
        sequence: the recording.
        folder: where to; it appears when everything in it is written.
        truth: what is true of the scene; None = nothing is written about it.
        lossless: colour as PNG instead of JPEG.

    Raises:
        BadInput: where the folder exists, or no frame can be used.
    """
    return write_scannet(sequence, folder, truth=truth, lossless=lossless, sens=True)


def _write_folders(folder: Path, frames: Iterable[Frame], suffix: str, *, has_poses: bool) -> int:
    count = 0
    for number, frame in enumerate(frames):
        write_color(folder / "color" / f"{number}{suffix}", frame.rgb)
        write_depth(folder / "depth" / f"{number}.png", frame.depth, UNITS_PER_M)
        if has_poses:
            pose = _UNKNOWN_POSE if frame.world_from_camera is None else frame.world_from_camera
            (folder / "pose").mkdir(exist_ok=True)
            (folder / "pose" / f"{number}.txt").write_text(matrix_lines(pose))
        count += 1
    return count


def _write_matrices(folder: Path, camera: Intrinsics) -> None:
    folder.mkdir()
    intrinsic = np.eye(4)
    intrinsic[:3, :3] = camera.matrix
    for kind in ("color", "depth"):
        (folder / f"intrinsic_{kind}.txt").write_text(matrix_lines(intrinsic))
        (folder / f"extrinsic_{kind}.txt").write_text(matrix_lines(np.eye(4)))


def _metadata(camera: Intrinsics, count: int) -> str:
    numbers = {"fx": camera.fx, "fy": camera.fy, "mx": camera.cx, "my": camera.cy}
    lines = [f"{kind}{name} = {x}" for kind in ("color", "depth") for name, x in _size(camera).items()]
    lines += [f"{name}_{kind} = {x:.6f}" for kind in ("color", "depth") for name, x in numbers.items()]
    lines.append("colorToDepthExtrinsics = " + " ".join(f"{x:.6f}" for x in np.eye(4).ravel()))
    lines += [f"numDepthFrames = {count}", f"numColorFrames = {count}", "numIMUmeasurements = 0"]
    return "".join(f"{line}\n" for line in lines)


def _size(camera: Intrinsics) -> dict[str, int]:
    return {"Width": camera.width, "Height": camera.height}
