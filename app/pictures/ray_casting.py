"""Ray casting of a mesh whose back faces are culled first: from outside one looks into rooms, from above under ceilings
that were seen from below."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import open3d as o3d
import open3d.core as o3c

from app.pictures.camera import PictureCamera
from razer.arrays import BoolArray, Float32Array, IntArray
from razer.mesh.labelled_mesh import LabelledMesh
from razer.semantics.normals import face_normals


@dataclass(frozen=True)
class RayHits:
    """What rays (H, W) meet first: corners (P, 3), the vertices of the triangle that each of the P pixels of `covered`
    (H, W) shows, with weights (P, 3) of these, and distance (H, W) from the eye, metres, infinite where there is
    nothing."""

    covered: BoolArray
    corners: IntArray
    weights: Float32Array
    distance: Float32Array

    @cached_property
    def nearest(self) -> IntArray:
        """The vertex (P,) nearest to what each pixel shows."""
        best: IntArray = np.take_along_axis(self.corners, self.weights.argmax(axis=1)[:, None], axis=1)[:, 0]
        return best

    def blended(self, values: Float32Array) -> Float32Array:
        """Values (V,) or (V, C) of the vertices, interpolated: (P,) or (P, C)."""
        weights = self.weights if values.ndim == 1 else self.weights[:, :, None]
        total: Float32Array = values[self.corners[:, 0]] * weights[:, 0]
        total += values[self.corners[:, 1]] * weights[:, 1]
        total += values[self.corners[:, 2]] * weights[:, 2]
        return total


class FrontFaces:
    """The triangles of a mesh that face a camera, ready to be met by its rays."""

    def __init__(self, mesh: LabelledMesh, camera: PictureCamera, left_out: BoolArray | None = None) -> None:
        """left_out (V,): vertices whose triangles are not drawn."""
        self.camera = camera
        self.triangles = front_facing(mesh, camera, left_out)
        self._scene = o3d.t.geometry.RaycastingScene()
        if len(self.triangles):
            self._scene.add_triangles(
                o3c.Tensor(np.ascontiguousarray(mesh.vertices, np.float32)),
                o3c.Tensor(np.ascontiguousarray(self.triangles, np.uint32)),
            )

    def cast(self, first_row: int, last_row: int) -> RayHits:
        """What the pixels of some rows of the camera's image show."""
        shape = (last_row - first_row, self.camera.size[0])
        if not len(self.triangles):
            return RayHits(
                np.zeros(shape, np.bool_),
                np.zeros((0, 3), np.int64),
                np.zeros((0, 3), np.float32),
                np.full(shape, np.inf, np.float32),
            )
        hits = self._scene.cast_rays(o3c.Tensor(self.camera.rays(first_row, last_row)))
        distance = hits["t_hit"].numpy()
        covered = np.isfinite(distance)
        corners = self.triangles[hits["primitive_ids"].numpy()[covered]]
        u, v = hits["primitive_uvs"].numpy()[covered].T
        return RayHits(covered, corners, np.stack([1 - u - v, u, v], axis=1), distance)


def front_facing(mesh: LabelledMesh, camera: PictureCamera, left_out: BoolArray | None = None) -> IntArray:
    """The triangles (T, 3) that face a camera, without those of vertices (V,) that are left out."""
    triangles = mesh.triangles
    if not len(triangles):
        return triangles
    first = mesh.vertices[triangles[:, 0]]
    faces = np.einsum("ij,ij->i", face_normals(mesh), camera.towards_eye(first)) > 0
    if left_out is not None:
        faces &= ~left_out[triangles].any(axis=1)
    return triangles[faces]
