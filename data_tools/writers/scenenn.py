"""Writer of the layout of SceneNN, with the ground truth.

Sources: the playback tool and the list of files in https://github.com/hkust-vgd/scenenn
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from data_tools.recordings.sequence import RgbdSequence
from data_tools.truth.class_names import nyu40_number
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.ply_writer import label_colors, write_ply
from data_tools.writers.frame_files import frames_to_write, matrix_lines, write_color, write_depth
from data_tools.writers.unfinished import unfinished
from razer.vocabulary import vocabulary

UNITS_PER_M = 1000.0


def write_scenenn(
    sequence: RgbdSequence, folder: Path, *, truth: GroundTruth | None = None, lossless: bool = False
) -> list[tuple[int, str]]:
    """Write every usable frame, numbered anew from 1, and return (index, reason) of the others.

    Depth is in millimetres (beyond 65.5 m: none); timestamp.txt holds microseconds; pose n of trajectory.log belongs
    to image n + 1. A truth becomes a mesh with labels and an xml.

    Args:
        sequence: the recording.
        folder: where to; it appears when everything in it is written.
        truth: what is true of the scene; None = nothing is written about it.
        lossless: without effect: colour is always PNG.

    Raises:
        BadInput: where the folder exists, or no frame can be used.
    """
    skipped: list[tuple[int, str]] = []
    stamps, poses = [], []
    with unfinished(folder) as hidden:
        for number, frame in enumerate(frames_to_write(sequence, skipped), start=1):
            write_color(hidden / "image" / f"image{number:05d}.png", frame.rgb)
            write_depth(hidden / "depth" / f"depth{number:05d}.png", frame.depth, UNITS_PER_M)
            microseconds = round(frame.stamp * 1e6)
            stamps.append(f"{number} {microseconds} {microseconds}\n")
            if frame.world_from_camera is not None:
                poses.append(f"{number - 1} {number - 1} {number}\n{matrix_lines(frame.world_from_camera)}")
        (hidden / "timestamp.txt").write_text("".join(stamps))
        (hidden / "intrinsic.txt").write_text(matrix_lines(sequence.intrinsics.matrix))
        if poses:
            (hidden / "trajectory.log").write_text("".join(poses))
        if truth is not None:
            _write_mesh(truth, hidden / f"{Path(folder).name}.ply")
            _write_labels(truth, hidden / f"{Path(folder).name}.xml")
    return skipped


def _write_mesh(truth: GroundTruth, path: Path) -> None:
    properties = {**label_colors(truth.instances), "label": truth.instances.astype("<u4")}
    write_ply(path, truth.vertices, properties, truth.triangles)


def _write_labels(truth: GroundTruth, path: Path) -> None:
    root = ElementTree.Element("annotation")
    for number, name in sorted(truth.instance_classes.items()):
        points = truth.vertices[truth.instances == number]
        box = " ".join(f"{x:.6g}" for x in (*points.min(axis=0), *points.max(axis=0)))
        color = " ".join(str(column[0]) for column in label_colors(np.array([number])).values())
        attributes = {"id": str(number), "color": color, "text": name, "nyu_class": _nyu40_name(name), "aabbox": box}
        ElementTree.SubElement(root, "label", attributes)
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def _nyu40_name(name: str) -> str:
    """The NYU40 class that a name belongs to, else empty."""
    category = vocabulary("nyu40").by_id.get(nyu40_number(name))
    return category.name if category else ""
