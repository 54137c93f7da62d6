"""Ground truth of Replica: habitat/mesh_semantic.ply with an object on each face, and habitat/info_semantic.json.

An object is nobody's where the json does not list it, and of no class where its class_id is not above 0. Sources:
https://github.com/facebookresearch/Replica-Dataset, ReplicaSemanticScene.cpp of habitat-sim
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from data_tools.truth.class_names import category_of
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.ply import Ply, read_ply
from data_tools.truth.vertex_colors import vertex_colors
from razer.arrays import Int64Array
from razer.errors import BadInput
from razer.files import MALFORMED, read_json
from razer.vocabulary import vocabulary

OWN_LIST = "replica"  # numbered as the files are
MESH, INFO = "mesh_semantic.ply", "info_semantic.json"


@dataclass(frozen=True, slots=True)
class ObjectClass:
    """The class of an object; a number that is not above 0 is no class."""

    number: int
    name: str


def is_replica_truth(folder: Path) -> bool:
    """Whether info_semantic.json is there or in habitat/."""
    return _habitat(folder) is not None


def read_replica_truth(folder: Path, vocabulary_name: str | None = None) -> GroundTruth:
    """The labelled mesh of a scene; raises BadInput. Instances are object ids, those of vertices by the majority of
    the faces round them, the lowest id of equals. Object 0 gets the first free number, as 0 is nobody here. Classes
    are numbered and named as in the file, or as in the vocabulary; the notes name those that it lacks."""
    habitat = _habitat(folder)
    if habitat is None:
        raise BadInput(f"{folder / 'habitat' / INFO} is missing: Replica's ground truth needs it and {MESH}")
    mesh = read_ply(habitat / MESH)
    if "object_id" not in mesh.of_face:
        raise BadInput(f"{habitat / MESH} has no face property object_id: take the mesh of the folder habitat/")
    points = mesh.points(habitat / MESH)
    objects = read_objects(habitat / INFO)
    of_vertex = majority_of_faces(mesh, mesh.of_face["object_id"].astype(np.int64), len(points))
    known, where = np.unique(of_vertex, return_inverse=True)
    free = max(objects, default=0) + 1
    instance_of = np.array([(i or free) if i in objects else 0 for i in known.tolist()], np.int32)
    classes, notes = _classes({i: objects[i] for i in known.tolist() if i in objects}, vocabulary_name)
    class_of = np.array([classes[i].number if i in classes else 0 for i in known.tolist()], np.int32)
    names = {each.number: each.name for each in classes.values()}
    visible = np.ones(len(points), np.bool_)
    listed, colors = vocabulary_name or OWN_LIST, vertex_colors(mesh)
    labels_of = instance_of[where], class_of[where]
    return GroundTruth(points, mesh.triangles, *labels_of, names, visible, notes, vocabulary=listed, colors=colors)


def read_objects(path: Path) -> Mapping[int, ObjectClass]:
    """The class of each object; raises BadInput naming the file."""
    try:
        objects = read_json(path)["objects"]
        return {int(each["id"]): ObjectClass(int(each["class_id"]), str(each["class_name"])) for each in objects}
    except MALFORMED as error:
        raise BadInput(
            f'{path} must be JSON with "objects" of id, class_id and class_name (problem: {error!r})'
        ) from None


def _classes(
    objects: Mapping[int, ObjectClass], vocabulary_name: str | None
) -> tuple[dict[int, ObjectClass], tuple[str, ...]]:
    """The class of each object that has one, and a note on names that are in the file but not in the vocabulary."""
    named = {i: each for i, each in objects.items() if each.number > 0}
    if vocabulary_name is None:
        return named, ()
    classes = vocabulary(vocabulary_name)
    category_by_object = {i: category_of(each.name, classes) for i, each in named.items()}
    lacking = sorted({named[i].name for i, category in category_by_object.items() if category is None})
    notes = (f"classes that are not in {classes.name}: {', '.join(lacking[:5])}",) if lacking else ()
    return {i: ObjectClass(category.id, category.name) for i, category in category_by_object.items() if category}, notes


def majority_of_faces(mesh: Ply, labels: Int64Array, count: int) -> Int64Array:
    """The label (V,) that most faces round each of `count` vertices have, the lowest of equals, -1 without any face;
    labels (T,) are those of the faces that the triangles are of."""
    # Triangles of one face share its first edges: each corner of a face counts once.
    first = np.diff(mesh.faces, prepend=-1) != 0
    corners = np.concatenate([mesh.triangles[first].ravel(), mesh.triangles[~first, 2]])
    kinds, kind = np.unique(np.concatenate([np.repeat(labels[first], 3), labels[~first]]), return_inverse=True)
    pairs, votes = np.unique(corners.astype(np.int64) * len(kinds) + kind, return_counts=True)
    best = np.lexsort((-pairs, votes))  # ascending: the last of a vertex has most votes, and the lowest label of those
    result = np.full(count, -1, np.int64)
    result[pairs[best] // len(kinds)] = kinds[pairs[best] % len(kinds)]
    return result


def _habitat(folder: Path) -> Path | None:
    return next((place for place in (folder / "habitat", folder) if (place / INFO).is_file()), None)
