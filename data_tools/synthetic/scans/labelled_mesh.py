"""Reader of any labelled mesh: a folder or file of a known layout, or a PLY whose properties say what is what.

Instances are sought among properties of vertices, then of faces; where there are only classes, as in ScanNet's
*_vh_clean_2.labels.ply, each connected part of one class is an instance.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from data_tools.synthetic.scans.connected_parts import connected_parts
from data_tools.truth import replica_truth, scannet_truth
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.open_truth import has_truth, open_truth
from data_tools.truth.ply import Ply, read_ply
from data_tools.truth.scenenn_truth import read_scenenn_mesh
from data_tools.truth.truth_folder import read_truth
from data_tools.truth.vertex_colors import vertex_colors
from razer.arrays import Int32Array, Int64Array
from razer.errors import BadInput
from razer.files import read_json
from razer.vocabulary import vocabulary

INSTANCES = ("instance", "instance_id", "instanceid", "object_id", "objectid", "object")
CLASSES = ("class", "class_id", "category", "category_id", "semantic", "semantic_id", "label", "label_id", "labels")
_SCANNET_LABELS = ".labels.ply"
_UNNAMED = "object"


def open_labelled_mesh(path: Path, scale: float = 1.0) -> GroundTruth:
    """The surface of a labelled mesh and whose each vertex is; raises BadInput.

    Args:
        path: a PLY file, or a folder with a truth in a layout of open_truth, or with mesh.ply.
        scale: metres per unit of the file.
    """
    if not path.exists():
        raise BadInput(f"{path} does not exist: give a labelled mesh (PLY) or a folder with one")
    if (truth := _read_known(path)) is None:
        return _read_any(path / "mesh.ply" if path.is_dir() else path, scale)
    return replace(truth, vertices=(truth.vertices * np.float32(scale)).astype(np.float32))


def _read_known(path: Path) -> GroundTruth | None:
    """The truth of a known layout that is, or has, this mesh."""
    if path.is_dir():
        return open_truth(path) if has_truth(path) or not (path / "mesh.ply").is_file() else None
    folder = path.parent
    if path.name == replica_truth.MESH and replica_truth.is_replica_truth(folder):
        return replica_truth.read_replica_truth(folder)
    if path.with_suffix(".xml").is_file():
        return read_scenenn_mesh(path)
    scene = path.name.removesuffix(scannet_truth.MESH)
    if scene != path.name and scannet_truth.is_scannet_truth(folder, scene):
        return scannet_truth.read_scannet_truth(folder, scene=scene)
    own = path.name == "mesh.ply" and (folder / "classes.json").is_file() and (folder / "objects.json").is_file()
    return read_truth(folder) if own else None


def _read_any(path: Path, scale: float) -> GroundTruth:
    mesh = read_ply(path)
    points = (mesh.points(path) * np.float32(scale)).astype(np.float32)
    instances, classes = (_labels(mesh, names, len(points)) for names in (INSTANCES, CLASSES))
    if instances is None and classes is None:
        raise BadInput(
            f"{path} has no labels: its vertices or faces need a number {INSTANCES[0]}, {INSTANCES[3]} or "
            f"{CLASSES[6]}; they have {', '.join([*mesh.vertices, *mesh.of_face])}"
        )
    notes: tuple[str, ...] = ()
    names = _class_names(path)
    if instances is None:
        assert classes is not None
        instances = connected_parts(points, mesh.triangles, classes)
        notes = (f"{path.name} has classes only: each connected part of one class is an instance",)
    if classes is None:
        classes, names = _classes_by_instance(path, instances)
    known = {number: names.get(number, f"class {number}") for number in np.unique(classes).tolist() if number > 0}
    visible, colors = np.ones(len(points), np.bool_), vertex_colors(mesh)
    return GroundTruth(points, mesh.triangles, instances, classes, known, visible, notes, colors=colors)


def stated_up(path: Path) -> tuple[float, ...] | None:
    """Which way is up, as the instances.json of a run beside its mesh says; None where nothing does."""
    run = _json((path if path.is_dir() else path.parent) / "instances.json")
    up = run.get("up") if isinstance(run, dict) else None
    if not isinstance(up, list) or len(up) != 3 or not all(isinstance(x, int | float) for x in up):
        return None
    return tuple(up) if any(up) else None


def renumbered(truth: GroundTruth, largest: int) -> GroundTruth:
    """The same with instances counted from 1 where one is above `largest`, which is what images of ids can hold."""
    if truth.instances.max(initial=0) <= largest:
        return truth
    known, where = np.unique(truth.instances.clip(0), return_inverse=True)
    numbers = np.arange(len(known)) + (known[0] > 0)
    note = f"instances are counted anew from 1, as some are above {largest}"
    return replace(truth, instances=numbers[where].astype(np.int32), notes=(*truth.notes, note))


def _labels(mesh: Ply, names: tuple[str, ...], count: int) -> Int32Array | None:
    """The first of these properties that vertices or else faces have, (V,) with 0 for nobody's."""
    for properties, of_face in ((mesh.vertices, False), (mesh.of_face, True)):
        by_name = {name.lower(): column for name, column in properties.items()}
        column = next((by_name[name] for name in names if name in by_name), None)
        if column is not None and column.ndim == 1:
            labels = _whole(column)
            labels = replica_truth.majority_of_faces(mesh, labels, count) if of_face else labels
            return labels.clip(0, np.iinfo(np.int32).max).astype(np.int32)
    return None


def _whole(column: NDArray) -> Int64Array:
    return np.rint(np.nan_to_num(column.astype(np.float64))).astype(np.int64)


def _class_names(path: Path) -> Mapping[int, str]:
    """The names in a classes.json beside a mesh; without one, those of NYU40 for ScanNet's labels."""
    content = _json(path.with_name("classes.json"))
    if isinstance(content, dict):
        try:
            return {int(number): str(name) for number, name in content.items()}
        except ValueError:
            raise BadInput(f"{path.with_name('classes.json')} must map class numbers to names") from None
    return {c.id: c.name for c in vocabulary("nyu40").categories} if path.name.endswith(_SCANNET_LABELS) else {}


def _classes_by_instance(path: Path, instances: Int32Array) -> tuple[Int32Array, dict[int, str]]:
    """Classes of vertices by the names that objects.json or a run's instances.json gives the instances; all those
    that have none are of class "object"."""
    runs = _json(path.with_name("instances.json"))
    entries = _json(path.with_name("objects.json")) or (runs.get("instances") if isinstance(runs, dict) else None)
    try:
        name_of = {int(entry["id"]): entry.get("class") or _UNNAMED for entry in entries or []}
    except (TypeError, KeyError, ValueError, AttributeError):
        raise BadInput(f"{path.with_name('objects.json')} must list objects with id and class") from None
    names = sorted({_UNNAMED, *name_of.values()})
    known, where = np.unique(instances, return_inverse=True)
    number_of = [names.index(name_of.get(i, _UNNAMED)) + 1 if i > 0 else 0 for i in known.tolist()]
    return np.array(number_of, np.int32)[where], dict(enumerate(names, start=1))


def _json(path: Path) -> Any:
    return read_json(path) if path.is_file() else None
