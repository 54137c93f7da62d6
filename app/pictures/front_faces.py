"""What a camera sees of a mesh whose back faces are culled first: from outside one looks into rooms, from above under
ceilings that were seen from below. OpenCV's rasteriser draws it: a few triangles a pixel are no work for rays."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from app.pictures.camera import PictureCamera
from razer.arrays import BoolArray, Float32Array, IntArray
from razer.mesh.labelled_mesh import LabelledMesh
from razer.semantics.normals import face_normals

_DIGIT = 4096  # numbers of triangles are drawn as two digits, each exact in a float


@dataclass(frozen=True)
class Seen:
    """What pixels (H, W) show: corners (P, 3), the vertices of the triangle that each of the P pixels of `covered`
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
    """The triangles of a mesh that face a camera, ready to be drawn."""

    def __init__(self, mesh: LabelledMesh, camera: PictureCamera, left_out: BoolArray | None = None) -> None:
        """left_out (V,): vertices whose triangles are not drawn."""
        self.camera = camera
        self.triangles = front_facing(mesh, camera, left_out)
        # Each triangle has corners of its own, which bear its number and their weights as colours.
        self._corners = camera.local(mesh.vertices)[self.triangles.ravel()]
        self._order = np.arange(3 * len(self.triangles), dtype=np.int32).reshape(-1, 3)
        number = np.repeat(np.arange(len(self.triangles)), 3)
        digits = np.stack([number % _DIGIT, number // _DIGIT, np.full_like(number, _DIGIT)], axis=1)
        self._number = (digits / _DIGIT).astype(np.float32)

    def seen(self, first_row: int, last_row: int) -> Seen:
        """What the pixels of some rows of the camera's image show."""
        shape = (last_row - first_row, self.camera.size[0])
        if not len(self.triangles):
            return Seen(
                np.zeros(shape, np.bool_),
                np.zeros((0, 3), np.int32),
                np.zeros((0, 3), np.float32),
                np.full(shape, np.inf, np.float32),
            )
        covered, numbers, depth = self._numbers(first_row, last_row)
        weights = self._drawn(np.tile(np.eye(3, dtype=np.float32), (len(self.triangles), 1)), first_row, last_row)[0][
            covered
        ]
        distance = np.where(covered, depth * self.camera.slant(first_row, last_row), np.inf)
        return Seen(covered, self.triangles[numbers], weights, distance.astype(np.float32))

    def vertices_seen(self) -> IntArray:
        """For each pixel that is covered a vertex (P,) of the triangle that it shows."""
        if not len(self.triangles):
            return np.zeros(0, np.int32)
        corners: IntArray = self.triangles[self._numbers(0, self.camera.size[1])[1], 0]
        return corners

    def _numbers(self, first_row: int, last_row: int) -> tuple[BoolArray, IntArray, Float32Array]:
        """Which pixels (H, W) of some rows are covered, the triangle (P,) that each shows, and depth (H, W)."""
        drawn, depth = self._drawn(self._number, first_row, last_row)
        covered = drawn[..., 2] > 0.5
        low, high = np.rint(drawn[covered][:, :2] * _DIGIT).astype(np.int32).T
        return covered, low + _DIGIT * high, depth

    def _drawn(self, colors: Float32Array, first_row: int, last_row: int) -> tuple[Float32Array, Float32Array]:
        """Colours (3 T, 3) of the corners, interpolated, and depth of some rows of the image."""
        width, height = self.camera.size[0], last_row - first_row
        x, y = self.camera.center_px
        focal, farthest = self.camera.depth_focal_px, 1.1 * float(self._corners[:, 2].max())
        # OpenGL's axes; what its camera has in the middle of the image, this one has at center_px.
        aside = np.array([(x - width / 2) / focal, (y - first_row - height / 2) / focal], np.float32)
        corners = self._corners * np.array([1, -1, -1], np.float32)
        corners[:, :2] += self._corners[:, 2:] * aside * np.array([1, -1], np.float32)
        settings = cv2.TriangleRasterizeSettings().setCullingMode(cv2.RASTERIZE_CULLING_NONE)
        color, depth = cv2.triangleRasterize(
            corners,
            self._order,
            colors,
            np.zeros((height, width, 3), np.float32),
            np.full((height, width), farthest, np.float32),
            np.eye(4, dtype=np.float32),
            2 * np.arctan(height / (2 * focal)),
            0.5 * float(self._corners[:, 2].min()),
            farthest,
            settings.setShadingType(cv2.RASTERIZE_SHADING_SHADED),
        )
        return color, depth


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
