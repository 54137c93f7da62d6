"""Instances known again in a map whose ids are others: by points of their surface."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

import numpy as np

from razer.arrays import Float64Array
from razer.edits.log import Before
from razer.map_object import MapObject
from razer.mesh.labelled_mesh import LabelledMesh

POINTS = 24  # of an instance: that a few of them lie on what was mapped anew decides nothing
REACH_M = 0.06  # of a point to the surface it is looked for on: maps made anew differ by a voxel or two
_SHARE = 0.5  # of the points on one instance from which it is the same


def fingerprint(mesh: LabelledMesh) -> str:
    """The same for two meshes of the same vertices and instances, and hardly ever for others."""
    digest = hashlib.blake2b(digest_size=8)
    for array in (mesh.vertices, mesh.instances):
        digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()


def before(item: MapObject, mesh: LabelledMesh) -> Before:
    """An instance as the log holds it: some of its vertices, evenly chosen."""
    rows = np.flatnonzero(mesh.instances == item.id)
    chosen = rows[np.linspace(0, len(rows) - 1, min(POINTS, len(rows))).round().astype(np.intp)]
    return Before(item.class_name, mesh.vertices[chosen].astype(np.float64))


class KnownAgain:
    """Finds instances by where they were, on a surface whose labels change as edits are applied."""

    def __init__(self, vertices: Float64Array) -> None:
        from scipy.spatial import KDTree  # late: a map whose ids are as they were needs none

        self._tree = KDTree(vertices)

    def ids(self, mesh: LabelledMesh, about: Mapping[int, Before]) -> dict[int, int]:
        """The id in a mesh of each instance by its own; those that are not found are left out."""
        found = {i: self._id(mesh, each.points) for i, each in about.items()}
        return {i: other for i, other in found.items() if other}

    def _id(self, mesh: LabelledMesh, points: Float64Array) -> int:
        if not len(points) or not len(mesh.vertices):
            return 0
        distance, row = self._tree.query(points, distance_upper_bound=REACH_M)
        labels = mesh.instances[row[np.isfinite(distance)]]
        counts = np.bincount(labels[labels > 0], minlength=1)
        return int(counts.argmax()) if counts.max() >= max(1.0, _SHARE * len(points)) else 0
