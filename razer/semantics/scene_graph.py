"""The scene graph of a map: what there is, and how it stands to each other."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from razer.arrays import Float64Array
from razer.boxes.oriented_box import OrientedBox
from razer.panoptic_map import PanopticMap
from razer.semantics.labelling import Segment
from razer.semantics.normals import vertex_normals
from razer.semantics.relations import relations
from razer.semantics.upright_instance import UprightInstance
from razer.storage.instances_json import box_entry


def scene_graph(panoptic: PanopticMap, found: list[Segment], up: Float64Array) -> dict[str, Any]:
    """{nodes, edges}: a node for each segment with the boxes of its instances in the world, in metres; edges {from, to,
    relation, distance_m} as `relations` tells them, `up` (3,) pointing upwards."""
    segment_of = {instance: segment for segment in found for instance in segment.instances}
    nearest: dict[tuple[int, int, str], float] = {}
    for edge in relations(list(_placed(panoptic, segment_of, up))):
        source, target = segment_of[edge.source].id, segment_of[edge.target].id
        key = (source, target, str(edge.relation))
        if source != target:
            nearest[key] = min(edge.distance_m, nearest.get(key, np.inf))
    edges = [
        {"from": source, "to": target, "relation": relation, "distance_m": round(distance_m, 3)}
        for (source, target, relation), distance_m in sorted(nearest.items())
    ]
    return {"nodes": [_node(panoptic, segment) for segment in found], "edges": edges}


def _node(panoptic: PanopticMap, segment: Segment) -> dict[str, Any]:
    boxes = {o.id: o.box for o in panoptic.objects}
    return {
        "id": segment.id,
        "class": segment.category.name,
        "score": round(segment.score, 4),
        "stuff": segment.category.stuff,
        "instances": [{"id": i, **box_entry(boxes[i])} for i in segment.instances],
        **box_entry(boxes[segment.id]),
    }


def _placed(panoptic: PanopticMap, segment_of: dict[int, Segment], up: Float64Array) -> Iterator[UprightInstance]:
    """The instances that have a class and a surface, turned so that z points up."""
    turn = Rotation.align_vectors([[0.0, 0.0, 1.0]], [up])[0].as_matrix()
    mesh = panoptic.mesh
    points, normals = mesh.vertices.astype(np.float64) @ turn.T, vertex_normals(mesh) @ turn.T
    order = np.argsort(mesh.instances, kind="stable")
    for item in panoptic.objects:
        start, end = np.searchsorted(mesh.instances[order], [item.id, item.id + 1])
        rows = order[start:end]
        if item.id in segment_of and len(rows):
            box = OrientedBox(turn @ item.box.center, turn @ item.box.rotation, item.box.extent)
            yield UprightInstance(item.id, points[rows], normals[rows], box, segment_of[item.id].category.stuff)
