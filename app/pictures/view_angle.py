"""From where a map is looked at: where azimuths begin, and the angle that shows most."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from app.pictures.camera import PictureCamera, axes_towards, fitted_camera
from app.pictures.front_faces import FrontFaces
from app.pictures.view import Angle
from app.render.mesh_decimation import cluster_vertices
from razer.arrays import BoolArray, Float64Array
from razer.mesh.labelled_mesh import LabelledMesh
from razer.semantics.normals import face_normals

_TRIAL_SIZE = (200, 150)
_EVERY = 7  # of the vertices, for the extent of a map
_TRIAL_CELLS = 70  # along the longest side of the map
_AZIMUTHS_DEG = tuple(range(15, 360, 30))
_ELEVATIONS_DEG = (46.0,)
_COVERED_WEIGHT = 0.35  # of the surface shown as a whole, beside the instances
_UPRIGHT = 0.3  # largest cosine between upwards and the normal of a wall


def camera_axes(up: Float64Array, front: Float64Array, angle: Angle) -> Float64Array:
    """Axes (3, 3), rows right, down and forward, of a camera that looks at a map from an angle; `up` (3,) and `front`
    (3,), where azimuths begin, are square to each other and of unit length."""
    turn = np.radians(angle.azimuth_deg)
    heading = np.cos(turn) * front + np.sin(turn) * np.cross(up, front)
    return axes_towards(up, heading, angle.elevation_deg)


def wall_heading(mesh: LabelledMesh, up: Float64Array) -> Float64Array:
    """A horizontal direction (3,) square to most of the walls: of the four the one nearest to the world's axis that is
    least upright; `up` (3,) of unit length."""
    side = np.eye(3)[np.abs(up).argmin()]
    side = side - (side @ up) * up
    side /= np.linalg.norm(side)
    across = np.cross(up, side)
    x, y, z = (face_normals(mesh) @ np.stack([side, across, up], axis=1)).T
    weights = np.hypot(x, y)
    is_wall = np.abs(z) < _UPRIGHT * weights
    turns = np.arctan2(y[is_wall], x[is_wall])
    # Walls repeat every quarter turn.
    quarter = np.angle((weights[is_wall] * np.exp(4j * turns)).sum()) / 4 if is_wall.any() else 0.0
    return np.cos(quarter) * side + np.sin(quarter) * across


def best_angle(
    mesh: LabelledMesh,
    up: Float64Array,
    front: Float64Array,
    wanted: Collection[int],
    left_out: BoolArray | None = None,
) -> Angle:
    """Of some angles around a map the one that shows most of the wanted instances, and of the map.

    Args:
        mesh: the labelled surface, not empty.
        up: (3,) upwards, of unit length.
        front: (3,) where azimuths begin.
        wanted: the instances that the picture is about; each counts by the root of what is seen of it, so that many
            things count more than one large one.
        left_out: (V,) vertices that are not drawn.
    """
    kept = mesh if left_out is None else _without(mesh, left_out)
    extent = np.ptp(np.quantile(kept.vertices[::_EVERY], [0.01, 0.99], axis=0), axis=0)
    small = cluster_vertices(kept, max(float(extent.max()) / _TRIAL_CELLS, 0.02))
    scores = {}
    for elevation in _ELEVATIONS_DEG:
        for azimuth in _AZIMUTHS_DEG:
            angle = Angle(float(azimuth), elevation)
            camera = fitted_camera(camera_axes(up, front, angle), small.vertices, _TRIAL_SIZE, 4)
            scores[angle] = _seen(small, camera, wanted)
    return max(scores, key=lambda angle: scores[angle])


def _without(mesh: LabelledMesh, left_out: BoolArray) -> LabelledMesh:
    triangles = mesh.triangles[~left_out[mesh.triangles].any(axis=1)]
    return LabelledMesh(mesh.vertices, mesh.colors, mesh.instances, triangles) if len(triangles) else mesh


def _seen(mesh: LabelledMesh, camera: PictureCamera, wanted: Collection[int]) -> float:
    seen = FrontFaces(mesh, camera).vertices_seen()
    counts = np.bincount(mesh.instances[seen].clip(min=0), minlength=1)
    of_wanted = sum(float(np.sqrt(counts[number])) for number in wanted if number < len(counts))
    return of_wanted + _COVERED_WEIGHT * float(np.sqrt(len(seen))) * max(len(wanted), 1) ** 0.5
