"""Tracks and their parts frozen to objects of the map, and a map whose instances are parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from razer.arrays import Int32Array
from razer.boxes.oriented_box import OrientedBox
from razer.map_object import MapObject
from razer.mesh.labelled_mesh import LabelledMesh

MIN_PART_VERTICES = 4  # of a part: fewer have no box worth the name

if TYPE_CHECKING:  # they bring torch along, which opening a saved map need not load
    from razer.tracking.parts.part_surface import PartSurface
    from razer.tracking.track import Track


def frozen(track: Track, n_vertices: int) -> MapObject:
    """A track as the map holds it."""
    embeddings, weights = track.bank.settled()
    return MapObject(
        id=track.id,
        class_name=track.class_name,
        score=track.confidence,
        box=track.box,
        n_voxels=track.n_voxels,
        n_vertices=n_vertices,
        observations=track.hits,
        first_frame=track.first_frame,
        last_frame=track.last_frame,
        embeddings=embeddings,
        weights=weights,
        views=track.views,
        is_stuff=track.is_stuff,
        class_votes=track.class_votes,
    )


def frozen_parts(
    surfaces: Sequence[PartSurface], mesh: LabelledMesh, newest_id: int, voxel_size_m: float
) -> tuple[tuple[MapObject, ...], Int32Array]:
    """Parts with ids above `newest_id`, in the order of their surfaces, and the part (V,) of each vertex, 0 = none."""
    labels = np.zeros(len(mesh.vertices), np.int32)
    parts = []
    for part_id, surface in enumerate(surfaces, start=newest_id + 1):
        labels[surface.vertices] = part_id
        points = mesh.vertices[surface.vertices].astype(np.float64)
        box, cells = OrientedBox.of_surface(points), np.unique(np.rint(points / voxel_size_m), axis=0)
        part = frozen(surface.track, len(points))
        parts.append(replace(part, id=part_id, part_of=surface.whole, box=box, n_voxels=len(cells)))
    return tuple(parts), labels


def parts_as_instances(
    objects: Sequence[MapObject], parts: Sequence[MapObject], mesh: LabelledMesh, vertex_parts: Int32Array
) -> tuple[tuple[MapObject, ...], LabelledMesh]:
    """Objects and mesh at the granularity of parts: each part an instance, and what is left of wholes. A whole of which
    nothing is left is none."""
    instances = np.where(vertex_parts > 0, vertex_parts, mesh.instances).astype(np.int32)
    wholes = {part.part_of for part in parts}
    left = np.bincount(instances, minlength=max((o.id for o in objects), default=0) + 1)
    kept = [replace(o, n_vertices=int(left[o.id])) if o.id in wholes else o for o in objects]
    kept = [o for o in kept if o.n_vertices or o.id not in wholes]
    return (*kept, *parts), replace(mesh, instances=instances)


def parts_on_wholes(
    parts: Sequence[MapObject], mesh: LabelledMesh, vertex_parts: Int32Array
) -> tuple[tuple[MapObject, ...], Int32Array]:
    """Parts and the part (V,) of each vertex once the mesh is labelled anew: each part lies on the instance that has
    most of its vertices, and on no other; of too few vertices for a box there is none."""
    of_part, labels, kept = vertex_parts.copy(), mesh.instances, []
    for part in parts:
        rows = np.flatnonzero(of_part == part.id)
        counts = np.bincount(labels[rows], minlength=1)
        whole = int(counts[1:].argmax()) + 1 if counts[1:].any() else 0
        own = rows[labels[rows] == whole] if whole else rows[:0]
        if len(own) == part.n_vertices:
            kept.append(replace(part, part_of=whole))
        elif len(own) >= MIN_PART_VERTICES:
            kept.append(replace(part.on_surface(mesh.vertices[own].astype(np.float64)), part_of=whole))
        else:
            own = rows[:0]
        of_part[np.setdiff1d(rows, own)] = 0
    return tuple(kept), of_part
