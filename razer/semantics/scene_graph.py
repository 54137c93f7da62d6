"""Scene graph of a map: segments as nodes, spatial relations as edges."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from razer.arrays import Float64Array
from razer.boxes.oriented_box import OrientedBox
from razer.map_object import MapObject
from razer.panoptic_map import PanopticMap
from razer.semantics.labelling import Segment
from razer.semantics.normals import vertex_normals
from razer.semantics.relations import Relation, relations
from razer.semantics.supporting_surface import NOBODY
from razer.semantics.upright_instance import UprightInstance
from razer.storage.instances_json import box_entry
from razer.vocabulary import Category


def scene_graph(panoptic: PanopticMap, segments: list[Segment], up: Float64Array) -> dict[str, Any]:
    """{nodes, edges}: a node for each segment with the boxes of its instances in the world, in metres; edges {from, to,
    relation, distance_m} as of `relations`, `up` (3,) pointing upwards. Parts are nodes, too, each "part of" its
    whole."""
    segment_of = {instance: segment for segment in segments for instance in segment.instances}
    nearest: dict[tuple[int, int, str], float] = {}
    category_of = {instance: segment.category for instance, segment in segment_of.items()}
    for edge in map_relations(panoptic, category_of, up):
        source, target = segment_of[edge.source].id, segment_of[edge.target].id
        key = (source, target, str(edge.relation))
        if source != target:
            nearest[key] = min(edge.distance_m, nearest.get(key, np.inf))
    edges = [
        {"from": source, "to": target, "relation": relation, "distance_m": round(distance_m, 3)}
        for (source, target, relation), distance_m in sorted(nearest.items())
    ]
    wholes = {part.id: segment_of[part.part_of] for part in panoptic.parts if part.part_of in segment_of}
    parts = [part for part in panoptic.parts if part.id in wholes and not wholes[part.id].category.stuff]
    nodes = [_node(panoptic, segment) for segment in segments] + [_part_node(p, wholes[p.id]) for p in parts]
    edges += [{"from": p.id, "to": wholes[p.id].id, "relation": "part of", "distance_m": 0.0} for p in parts]
    return {"nodes": nodes, "edges": edges}


def _part_node(part: MapObject, whole: Segment) -> dict[str, Any]:
    """The node of a part, which the vocabulary has no name for: that of its whole, and its own where it has one."""
    own = part.class_name if part.class_name != whole.category.name else None
    return {
        "id": part.id,
        "class": f"{whole.category.name} {own or 'part'}",
        "score": round(part.score, 4),
        "stuff": False,
        "part_of": whole.id,
        "instances": [{"id": part.id, **box_entry(part.box)}],
        **box_entry(part.box),
    }


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


def map_relations(panoptic: PanopticMap, categories: Mapping[int, Category], up: Float64Array) -> list[Relation]:
    """The relations of the instances of a map that have a category, by id; `up` (3,) points upwards."""
    turn = Rotation.align_vectors([[0.0, 0.0, 1.0]], [up])[0].as_matrix()
    mesh = panoptic.mesh
    points, normals = mesh.vertices.astype(np.float64) @ turn.T, vertex_normals(mesh) @ turn.T
    order = np.argsort(mesh.instances, kind="stable")
    upright = []
    for item in panoptic.objects:
        rows = order[slice(*np.searchsorted(mesh.instances[order], [item.id, item.id + 1]))]
        if len(rows) and (category := categories.get(item.id)):
            box = OrientedBox(turn @ item.box.center, turn @ item.box.rotation, item.box.extent)
            upright.append(UprightInstance(item.id, points[rows], normals[rows], box, category.stuff, category.name))
    rest = ~np.isin(mesh.instances, [instance.id for instance in upright])
    return relations(upright, _background(points[rest], normals[rest]))


def _background(points: Float64Array, normals: Float64Array) -> UprightInstance | None:
    """The surface that belongs to no instance with a category."""
    if not len(points):
        return None
    return UprightInstance(NOBODY, points, normals, OrientedBox.around(points[:1], np.eye(3)))
