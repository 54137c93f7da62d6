"""Ground truth of ScanNet: a mesh, the segment each of its vertices is in, and the segments of each object.

scene0000_00_vh_clean_2.ply, scene0000_00_vh_clean_2.0.010000.segs.json and scene0000_00.aggregation.json; or the same
of the mesh in full resolution, scene0000_00_vh_clean.*. As in the benchmark, the instance of object n is n + 1, and of
two objects that share a segment the later one has it. Source:
https://github.com/ScanNet/ScanNet/tree/master/BenchmarkScripts
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from data_tools.truth.class_names import category_of
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.label_map import FILE_NAME, LabelMap, find_label_map, read_label_map
from data_tools.truth.ply import read_ply
from data_tools.truth.vertex_colors import vertex_colors
from razer.arrays import IndexArray, Int64Array
from razer.errors import BadInput
from razer.files import MALFORMED, read_json
from razer.vocabulary import Category, Vocabulary, vocabulary

MESH, SEGMENTS, OBJECTS = "_vh_clean_2.ply", "_vh_clean_2.0.010000.segs.json", ".aggregation.json"
_FULL_MESH, _FULL_SEGMENTS, _FULL_OBJECTS = "_vh_clean.ply", "_vh_clean.segs.json", "_vh_clean.aggregation.json"


@dataclass(frozen=True, slots=True)
class Annotated:
    """One object of an aggregation: its number from 0, the annotator's name for it, and its segments."""

    number: int
    label: str
    segments: tuple[int, ...]


def is_scannet_truth(folder: Path, scene: str | None = None) -> bool:
    """Whether there is an aggregation of objects."""
    return any(folder.glob(f"{scene or '*'}{OBJECTS}")) or any(folder.glob(f"{scene or '*'}{_FULL_OBJECTS}"))


def read_scannet_truth(
    folder: Path, vocabulary_name: str = "scannet200", *, scene: str | None = None, labels: Path | None = None
) -> GroundTruth:
    """The annotated mesh of a scene.

    Raw names get classes by the label map, or where there is none by their names alone, which the notes say. A name
    that is in no list leaves its objects without class, and is in the notes.

    Args:
        folder: where the files of the scene are.
        vocabulary_name: the list whose classes the objects get.
        scene: which, where the folder holds several; None = the one it is called by, else the first.
        labels: the label map; None = the one in the folder or above it.

    Raises:
        BadInput: naming the file that is missing or does not fit.
    """
    mesh_file, segments_file, objects_file = _files(folder, scene or _scene(folder))
    mesh = read_ply(mesh_file)
    points, segment_of = mesh.points(mesh_file), read_segments(segments_file)
    if len(segment_of) != len(points):
        raise BadInput(
            f"{segments_file} is for {len(segment_of)} vertices but {mesh_file.name} has {len(points)}: "
            f"they are of different scenes or versions, download both again"
        )
    objects = read_objects(objects_file)
    label_map = find_label_map(folder) if labels is None else read_label_map(labels)
    classes = vocabulary(vocabulary_name)
    category_by_label, notes = _categories(objects, classes, label_map)
    segments, where = np.unique(segment_of, return_inverse=True)
    owner_of, missing = _owners(segments, objects)
    if missing and not owner_of.any():
        raise BadInput(
            f"{objects_file} names none of the segments in {segments_file.name}: they are of different meshes"
        )
    notes += (f"{missing} segments of {objects_file.name} are not in {segments_file.name}",) if missing else ()
    categories = [category_by_label.get(each.label) for each in objects]
    instance_of = np.array([0, *(each.number + 1 for each in objects)], np.int32)
    class_of = np.array([0, *(category.id if category else 0 for category in categories)], np.int32)
    names = {category.id: category.name for category in categories if category}
    owners, visible = owner_of[where], np.ones(len(points), np.bool_)
    labels_of, colors = (instance_of[owners], class_of[owners]), vertex_colors(mesh)
    return GroundTruth(
        points, mesh.triangles, *labels_of, names, visible, notes, vocabulary=vocabulary_name, colors=colors
    )


def read_segments(path: Path) -> Int64Array:
    """The segment of each vertex, (V,); raises BadInput naming the file."""
    try:
        segments = np.array(read_json(path)["segIndices"])
    except MALFORMED as error:
        raise BadInput(f'{path} must be JSON with "segIndices", a number for each vertex (problem: {error})') from None
    if segments.ndim != 1 or not (np.issubdtype(segments.dtype, np.integer) or not segments.size):
        raise BadInput(f'{path} must be JSON with "segIndices", a number for each vertex')
    return segments.astype(np.int64)


def read_objects(path: Path) -> tuple[Annotated, ...]:
    """The objects of an aggregation in their order; raises BadInput naming the file."""
    try:
        objects = tuple(
            Annotated(int(group["objectId"]), str(group["label"]), tuple(int(s) for s in group["segments"]))
            for group in read_json(path)["segGroups"]
        )
    except MALFORMED as error:
        raise BadInput(
            f'{path} must be JSON with "segGroups" of objectId, label and segments (problem: {error!r})'
        ) from None
    if any(each.number < 0 for each in objects):
        raise BadInput(f"{path} has an objectId below 0")
    return objects


def _scene(folder: Path) -> str:
    """The scene that a folder is called by, or else the first that it holds."""
    scenes = [
        path.name.removesuffix(end) for end in (_FULL_OBJECTS, OBJECTS) for path in sorted(folder.glob(f"*{end}"))
    ]
    return folder.name if folder.name in scenes or not scenes else scenes[0]


def _files(folder: Path, scene: str) -> tuple[Path, Path, Path]:
    """Mesh, segments and objects; those of the smaller mesh, which the benchmark uses, where they are there."""
    first = tuple(folder / f"{scene}{end}" for end in (MESH, SEGMENTS, OBJECTS))
    full = tuple(folder / f"{scene}{end}" for end in (_FULL_MESH, _FULL_SEGMENTS, _FULL_OBJECTS))
    mesh, segments, objects = full if not first[0].is_file() and full[0].is_file() else first
    # Older downloads have the objects of the smaller mesh under the other name.
    objects = full[2] if not objects.is_file() and full[2].is_file() else objects
    for path in (mesh, segments, objects):
        if not path.is_file():
            raise BadInput(f"{path} is missing: ScanNet's ground truth needs *{MESH}, *{SEGMENTS} and *{OBJECTS}")
    return mesh, segments, objects


def _categories(
    objects: tuple[Annotated, ...], classes: Vocabulary, label_map: LabelMap | None
) -> tuple[dict[str, Category | None], tuple[str, ...]]:
    """The class of each label, and notes on labels that are unknown."""
    counts = Counter(each.label for each in objects)
    notes = [f"no {FILE_NAME} in the folder or above it: classes by their names alone"] if label_map is None else []
    if label_map is None:
        category_by_label = {label: category_of(label, classes) for label in counts}
        unknown, source = [label for label in counts if not category_by_label[label]], classes.name
    else:
        category_by_label = {label: label_map.category(label, classes) for label in counts if label in label_map.rows}
        unknown, source = [label for label in counts if label not in category_by_label], label_map.path.name
    if unknown:
        number, named = sum(counts[label] for label in unknown), ", ".join(sorted(unknown)[:5])
        notes.append(f"{number} objects have no class, as their names are not in {source}: {named}")
    return category_by_label, tuple(notes)


def _owners(segments: Int64Array, objects: tuple[Annotated, ...]) -> tuple[IndexArray, int]:
    """Which object each segment belongs to, counted from 1 (0 = none), and how many segments of objects are not
    among them."""
    owner_of, missing = np.zeros(len(segments), np.intp), 0
    for place, each in enumerate(objects, start=1):
        known = np.isin(segments, np.array(each.segments, np.int64))
        owner_of[known] = place
        missing += len(set(each.segments)) - int(known.sum())
    return owner_of, missing
