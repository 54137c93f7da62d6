"""Gravity direction from horizontal surfaces: floors, table tops and ceilings show it better than a camera's pose."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array
from razer.mesh.labelled_mesh import LabelledMesh
from razer.semantics.normals import face_normals

_CONES_DEG = (45.0, 25.0, 12.0, 6.0)


def up_direction(mesh: LabelledMesh, guess: Float64Array) -> Float64Array:
    """The unit direction (3,) that most horizontal surface faces, up or down, starting within 45 degrees of `guess`
    (3,); the guess itself where no surface lies so, or where it has no length."""
    if not np.linalg.norm(guess) > 0:
        return guess
    up: Float64Array = guess / np.linalg.norm(guess)
    normals = face_normals(mesh)
    areas = np.linalg.norm(normals, axis=1)
    for cone in _CONES_DEG:
        along = normals @ up
        mean = (normals * np.sign(along)[:, None])[np.abs(along) > np.cos(np.radians(cone)) * areas].sum(axis=0)
        length = np.linalg.norm(mean)
        if length > 0:
            up = mean / length
    return up
