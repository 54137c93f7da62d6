"""The truth/ folder of a recording: mesh.ply with instance and class per vertex, classes.json, objects.json."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from data_tools.truth.ground_truth import GroundTruth
from razer.frame import BadInput

_VERTEX = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("instance", "<i4"), ("class", "<i4"), ("visible", "u1")])
_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
_PLY_TYPES = {"<f4": "float", "<i4": "int", "|u1": "uchar"}


def write_json(path: Path, content: object) -> None:
    """Write JSON a person can read, making the folder it lies in."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content, indent=2) + "\n")


def write_objects(folder: Path, classes: Mapping[int, str]) -> None:
    """objects.json: the class name of each instance id."""
    write_json(folder / "objects.json", [{"id": i, "class": c} for i, c in sorted(classes.items())])


def write_truth(truth: GroundTruth, folder: Path) -> None:
    """Write a ground truth; vertices also say whether they are visible (0 or 1)."""
    write_objects(folder, truth.instance_classes)
    write_json(folder / "classes.json", {str(number): name for number, name in sorted(truth.class_names.items())})
    vertices = np.empty(len(truth.vertices), _VERTEX)
    for axis, name in enumerate("xyz"):
        vertices[name] = truth.vertices[:, axis]
    vertices["instance"], vertices["class"], vertices["visible"] = truth.instances, truth.classes, truth.visible
    faces = np.empty(len(truth.triangles), _FACE)
    faces["count"], faces["corners"] = 3, truth.triangles
    header = _header(len(vertices), len(faces))
    (folder / "mesh.ply").write_bytes(header + vertices.tobytes() + faces.tobytes())


def read_truth(folder: Path) -> GroundTruth:
    """Read what write_truth wrote; raises BadInput naming the file that is missing or of another kind."""
    try:
        data = (folder / "mesh.ply").read_bytes()
        names = {int(k): str(v) for k, v in json.loads((folder / "classes.json").read_text()).items()}
    except FileNotFoundError as error:
        raise BadInput(f"{error.filename} is missing: the truth needs mesh.ply and classes.json") from None
    except ValueError as error:
        raise BadInput(f"{folder / 'classes.json'} must map class numbers to names (problem: {error})") from error
    end = data.find(b"end_header\n") + len(b"end_header\n")
    counts = [int(line.split()[2]) for line in data[:end].splitlines() if line.startswith(b"element ")]
    if len(counts) != 2 or data[:end] != _header(*counts):
        wanted = ", ".join(_VERTEX.names or ())
        raise BadInput(f"{folder / 'mesh.ply'} is no truth mesh: it needs vertices with {wanted}")
    if len(data) != end + counts[0] * _VERTEX.itemsize + counts[1] * _FACE.itemsize:
        raise BadInput(f"{folder / 'mesh.ply'} is cut short: write it anew")
    vertices = np.frombuffer(data, _VERTEX, counts[0], end)
    return GroundTruth(
        np.stack([vertices[axis] for axis in "xyz"], axis=1),
        np.frombuffer(data, _FACE, counts[1], end + vertices.nbytes)["corners"].copy(),
        vertices["instance"].copy(),
        vertices["class"].copy(),
        names,
        vertices["visible"].astype(np.bool_),
    )


def _header(vertices: int, faces: int) -> bytes:
    properties = [f"property {_PLY_TYPES[_VERTEX[name].str]} {name}" for name in _VERTEX.names or ()]
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {vertices}", *properties]
    lines += [f"element face {faces}", "property list uchar int vertex_indices", "end_header", ""]
    return "\n".join(lines).encode()
