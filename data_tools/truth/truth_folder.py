"""Ground truth as a folder truth/: mesh.ply with instance and class per vertex, classes.json, objects.json, and perhaps
relations.json."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from data_tools.recordings import rgbd_calibration
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.ply import read_ply
from data_tools.truth.ply_writer import write_ply
from data_tools.truth.vertex_colors import vertex_colors
from razer.errors import BadInput
from razer.files import MALFORMED, MissingFile, read_json

RELATIONS = "relations.json"


def write_json(path: Path, content: object) -> None:
    """Write JSON a person can read, making the folder it lies in."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content, indent=2) + "\n")


def write_objects(folder: Path, classes: Mapping[int, str]) -> None:
    """objects.json: the class name of each instance id."""
    write_json(folder / "objects.json", [{"id": i, "class": c} for i, c in sorted(classes.items())])


def write_truth(truth: GroundTruth, folder: Path) -> None:
    """Write a ground truth; vertices also say whether they are visible (0 or 1). Beside it rgbd_calibration.json, where
    the truth knows a colour camera other than the declared one."""
    write_objects(folder, truth.instance_classes)
    write_json(folder / "classes.json", {str(number): name for number, name in sorted(truth.class_names.items())})
    if truth.relations is not None:
        rows = [{"a": a, "relation": relation, "b": b} for a, relation, b in truth.relations]
        write_json(folder / RELATIONS, rows)
    properties = {"instance": truth.instances.astype("<i4"), "class": truth.classes.astype("<i4")}
    properties |= {"visible": truth.visible.astype(np.uint8)}
    if truth.colors is not None:
        properties |= dict(zip(("red", "green", "blue"), truth.colors.T, strict=True))
    write_ply(folder / "mesh.ply", truth.vertices, properties, truth.triangles)
    if truth.rgbd_calibration is not None:
        write_json(folder / rgbd_calibration.FILE_NAME, truth.rgbd_calibration.to_json())


def read_truth(folder: Path) -> GroundTruth:
    """Read what write_truth wrote, or a mesh that others labelled alike (without `visible`, all of it is); raises
    BadInput naming the file that is missing or of another kind."""
    path = folder / "mesh.ply"
    try:
        names = {int(k): str(v) for k, v in read_json(folder / "classes.json").items()}
    except MissingFile:
        raise BadInput(f"{folder / 'classes.json'} is missing: the truth needs mesh.ply and classes.json") from None
    except MALFORMED as error:
        raise BadInput(f"{folder / 'classes.json'} must map class numbers to names (problem: {error})") from error
    if not path.is_file():
        raise BadInput(f"{path} is missing: the truth needs mesh.ply and classes.json")
    mesh = read_ply(path)
    points = mesh.points(path)
    instances, classes = (mesh.column(name, path).astype(np.int32) for name in ("instance", "class"))
    unnamed = sorted(set(np.unique(classes[classes > 0]).tolist()) - names.keys())
    names |= {number: f"class {number}" for number in unnamed}
    notes = (f"classes.json has no name for {', '.join(names[n] for n in unnamed[:5])}",) if unnamed else ()
    visible = mesh.vertices.get("visible", np.ones(len(points))).astype(np.bool_)
    colors, relations = vertex_colors(mesh), read_relations(folder / RELATIONS)
    labels = instances, classes
    return GroundTruth(points, mesh.triangles, *labels, names, visible, notes, colors=colors, relations=relations)


def read_relations(path: Path) -> tuple[tuple[int, str, int], ...] | None:
    """The relations (instance, relation, instance) of a truth; None without the file. Raises BadInput."""
    try:
        rows = read_json(path)
        return tuple((int(row["a"]), str(row["relation"]), int(row["b"])) for row in rows)
    except MissingFile:
        return None
    except MALFORMED as error:
        raise BadInput(f"{path} must list {{a, relation, b}} with ids of objects (problem: {error})") from error
