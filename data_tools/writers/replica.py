"""Writer of the layout in which NICE-SLAM rendered Replica, with the ground truth as Replica itself has it.

Sources: https://github.com/cvg/nice-slam, https://github.com/facebookresearch/Replica-Dataset
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from data_tools.recordings.sequence import RgbdSequence
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.ply_writer import label_colors, write_ply
from data_tools.truth.replica_truth import INFO, MESH
from data_tools.writers.frame_files import frames_to_write, write_color, write_depth
from data_tools.writers.unfinished import unfinished
from razer.arrays import Float32Array, Int32Array
from razer.frame import Intrinsics
from razer.vocabulary import vocabulary

UNITS_PER_M = 6553.5
_UNKNOWN_POSE = np.full((4, 4), np.nan)


def write_replica(
    sequence: RgbdSequence, folder: Path, *, truth: GroundTruth | None = None, lossless: bool = False
) -> list[tuple[int, str]]:
    """Write every usable frame, numbered anew from 0, and return (index, reason) of the others.

    results/ holds frame000000.jpg (.png if lossless) and depth000000.png in 1/6553.5 m, so that what is beyond 10 m
    becomes none; traj.txt a line for each frame, nan where its pose is unknown. cam_params.json, which the dataset
    has once for all scenes, stands in the folder. A truth becomes habitat/: objects on faces, by their corners.

    Args:
        sequence: the recording.
        folder: where to; it appears when everything in it is written.
        truth: what is true of the scene; None = nothing is written about it.
        lossless: colour as PNG instead of JPEG.

    Raises:
        BadInput: where the folder exists, or no frame can be used.
    """
    skipped: list[tuple[int, str]] = []
    poses = []
    with unfinished(folder) as hidden:
        for number, frame in enumerate(frames_to_write(sequence, skipped)):
            suffix = "png" if lossless else "jpg"
            write_color(hidden / "results" / f"frame{number:06d}.{suffix}", frame.rgb)
            write_depth(hidden / "results" / f"depth{number:06d}.png", frame.depth, UNITS_PER_M)
            pose = _UNKNOWN_POSE if frame.world_from_camera is None else frame.world_from_camera
            poses.append(" ".join(f"{x:.18e}" for x in pose.ravel()) + "\n")
        if sequence.has_poses:
            (hidden / "traj.txt").write_text("".join(poses))
        (hidden / "cam_params.json").write_text(json.dumps(_camera(sequence.intrinsics), indent=4) + "\n")
        if truth is not None:
            _write_truth(truth, hidden / "habitat")
    return skipped


def _camera(camera: Intrinsics) -> dict[str, dict[str, float]]:
    numbers = {"w": camera.width, "h": camera.height, "fx": camera.fx, "fy": camera.fy, "cx": camera.cx}
    return {"camera": numbers | {"cy": camera.cy, "scale": UNITS_PER_M}}


def _write_truth(truth: GroundTruth, folder: Path) -> None:
    folder.mkdir()
    of_face = {"object_id": _of_faces(truth).astype("<i4")}
    write_ply(folder / MESH, truth.vertices, label_colors(truth.instances), truth.triangles, of_face)
    numbers = _class_numbers(truth)
    objects = []
    for instance in np.unique(truth.instances[truth.instances > 0]).tolist():
        name = truth.instance_classes.get(instance, "undefined")
        box = _box(truth.vertices[truth.instances == instance])
        objects.append({"id": instance, "class_id": numbers.get(name, -1), "class_name": name, "oriented_bbox": box})
    classes = [{"id": number, "name": name} for name, number in numbers.items()]
    labels = np.full(truth.instances.max(initial=0) + 1, -1)
    for each in objects:
        labels[each["id"]] = each["class_id"]
    info = {"classes": classes, "id_to_label": labels.tolist(), "objects": objects, "gravity_dir": [0.0, 0.0, -1.0]}
    (folder / INFO).write_text(json.dumps(info, indent=1) + "\n")


def _class_numbers(truth: GroundTruth) -> dict[str, int]:
    """Replica's classes, and after them the names that are none of them."""
    numbers = {category.name: category.id for category in vocabulary("replica").categories}
    others = sorted(set(truth.instance_classes.values()) - numbers.keys())
    return numbers | {name: number for number, name in enumerate(others, start=max(numbers.values()) + 1)}


def _of_faces(truth: GroundTruth) -> Int32Array:
    """The instance of each triangle: that of two corners or more, else of the first."""
    a, b, c = truth.instances[truth.triangles].T
    return np.where(b == c, b, a)


def _box(points: Float32Array) -> dict[str, dict[str, list[float]]]:
    low, high = points.min(axis=0).astype(float), points.max(axis=0).astype(float)
    box = {"center": ((low + high) / 2).tolist(), "sizes": (high - low).tolist()}
    return {"abb": box, "orientation": {"rotation": [0.0, 0.0, 0.0, 1.0], "translation": [0.0, 0.0, 0.0]}}
