"""Writer of ground truth as ScanNet has it: mesh, segments, aggregation of objects, and the label map.

Each object is one segment, numbered as the instance; segment 0 is nobody's. ScanNet knows no class without object: a
surface with class but without instance becomes one object for each class, with the instance numbers after the last.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from data_tools.truth.class_names import nyu40_number
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.label_map import FILE_NAME
from data_tools.truth.ply_writer import label_colors, write_ply
from data_tools.truth.scannet_truth import MESH, OBJECTS, SEGMENTS
from razer.arrays import Int32Array
from razer.vocabulary import vocabulary

UNKNOWN = "unknown"
_COLUMNS = (
    "id", "raw_category", "category", "count", "nyu40id", "eigen13id", "nyuClass", "nyu40class", "eigen13class",
    "ModelNet40", "ModelNet10", "ShapeNetCore55", "synsetoffset", "wnsynsetid", "wnsynsetkey", "mpcat40",
    "mpcat40index",
)  # fmt: skip
_PARAMS = {
    "kThresh": "0.01", "segMinVerts": "20", "minPoints": "750", "maxPoints": "30000", "thinThresh": "0.05",
    "flatThresh": "0.001", "minLength": "0.02", "maxLength": "1",
}  # fmt: skip


def write_scannet_truth(truth: GroundTruth, folder: Path, scene: str) -> None:
    """Write the files of a scene's annotation; which vertices are visible has no place in them."""
    instances, labels = _objects(truth)
    colors = label_colors(instances) | {"alpha": np.full(len(instances), 255, np.uint8)}
    write_ply(folder / f"{scene}{MESH}", truth.vertices, colors, truth.triangles)
    segments = {"params": _PARAMS, "sceneId": scene, "segIndices": instances.tolist()}
    (folder / f"{scene}{SEGMENTS}").write_text(json.dumps(segments))
    groups = [
        {"id": instance - 1, "objectId": instance - 1, "segments": [instance], "label": label}
        for instance, label in sorted(labels.items())
    ]
    aggregation = {"sceneId": f"scannet.{scene}", "appId": "Aggregator.v2", "segGroups": groups}
    aggregation["segmentsFile"] = f"scannet.{scene}{SEGMENTS}"
    (folder / f"{scene}{OBJECTS}").write_text(json.dumps(aggregation))
    (folder / FILE_NAME).write_text(_label_map(list(labels.values())), encoding="utf-8")


def _objects(truth: GroundTruth) -> tuple[Int32Array, dict[int, str]]:
    """The instance of each vertex, and the name of each instance."""
    instances, names = truth.instances.copy(), truth.instance_classes
    labels = {i: names.get(i, UNKNOWN) for i in np.unique(instances).tolist() if i > 0}
    for number in np.unique(truth.classes[instances == 0]).tolist():
        if number > 0:
            instance = max(labels, default=0) + 1
            instances[(truth.instances == 0) & (truth.classes == number)] = instance
            labels[instance] = truth.class_names[number]
    return instances, labels


def _label_map(labels: list[str]) -> str:
    """A row for each name, as the rows of ScanNet's own file; names that it lacks get ids after its last."""
    known, nyu40 = vocabulary("scannet200"), vocabulary("nyu40")
    free = max(known.by_id) + 1
    rows = ["\t".join(_COLUMNS)]
    for label in sorted(set(labels)):
        number, nyu40_id = known.by_name[label].id if label in known.by_name else 0, nyu40_number(label)
        if not number and label != UNKNOWN:
            number, free = free, free + 1
        nyu40_class = nyu40.by_id[nyu40_id].name if nyu40_id else ""
        row = {"id": number, "raw_category": label, "category": label, "count": labels.count(label)}
        row |= {"nyu40id": nyu40_id, "nyu40class": nyu40_class}
        rows.append("\t".join(str(row.get(column, "")) for column in _COLUMNS))
    return "".join(f"{row}\n" for row in rows)
