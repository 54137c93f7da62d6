"""A labelled triangle mesh as rays meet it: scanned surfaces have a front, and holes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import open3d as o3d

from data_tools.truth.ground_truth import GroundTruth
from razer.arrays import BoolArray, Float32Array, Float64Array, Int32Array, Int64Array, Uint8Array
from razer.errors import BadInput
from razer.geometry import transform_points

# Least and most that a scan is across, metres.
_EXTENT_M = (1.0, 300.0)
_UNITS = {"millimetres": 0.001, "centimetres": 0.01, "kilometres": 1000.0}


@dataclass(frozen=True, slots=True, eq=False)
class ScannedSurface:
    """vertices (V, 3) float32 metres; triangles (T, 3) int32 with unit normals (T, 3) and areas (T,) in square metres;
    instances (V,) int32, 0 = nobody's; colors (V, 3) uint8; two_sided: the sides that triangles turn to the room do not
    agree, so that each is seen from both; scene: for rays."""

    vertices: Float32Array
    triangles: Int32Array
    normals: Float64Array
    areas: Float64Array
    instances: Int32Array
    colors: Uint8Array
    two_sided: bool
    scene: o3d.t.geometry.RaycastingScene

    @classmethod
    def of(
        cls,
        vertices: Float32Array,
        triangles: Int32Array,
        instances: Int32Array,
        colors: Uint8Array | None,
        *,
        two_sided: bool = False,
    ) -> ScannedSurface:
        """The surface of a mesh; triangles without area are left out. Without colours each instance has one, darker
        where it is turned away from the light."""
        cross = _cross(vertices, triangles)
        doubled = np.linalg.norm(cross, axis=1)
        there = doubled > 0
        triangles, cross, doubled = triangles[there], cross[there], doubled[there]
        normals = cross / doubled[:, None]
        if colors is None:
            colors = _painted(vertices, triangles, normals, instances)
        scene = o3d.t.geometry.RaycastingScene()
        to_tensor = o3d.core.Tensor.from_numpy
        scene.add_triangles(to_tensor(vertices), to_tensor(triangles.astype(np.uint32)))
        return cls(vertices, triangles, normals, doubled / 2, instances, colors, two_sided, scene)

    @property
    def vertex_normals(self) -> Float64Array:
        """Unit normals (V, 3) of the vertices, means of those of the triangles round them by area."""
        return _vertex_normals(len(self.vertices), self.triangles, self.normals * self.areas[:, None])

    def turned(self) -> ScannedSurface:
        """The same with every triangle turned round."""
        args = self.vertices, self.triangles[:, ::-1].copy(), self.instances, self.colors
        return ScannedSurface.of(*args, two_sided=self.two_sided)

    def seen_from_both_sides(self) -> ScannedSurface:
        """The same without front and back."""
        return replace(self, two_sided=True)

    def cast(self, origins: Float32Array, directions: Float32Array) -> tuple[Float32Array, Int64Array, Float32Array]:
        """What rays (..., 3) meet first: distance in lengths of their direction (inf = nothing), triangle (-1 = none,
        or one whose back they meet), and the weights (..., 3) of its corners."""
        rays = np.concatenate([np.broadcast_to(origins, directions.shape), directions], axis=-1)
        hits = self.scene.cast_rays(o3d.core.Tensor.from_numpy(np.ascontiguousarray(rays, np.float32)))
        triangle = hits["primitive_ids"].numpy().view(np.int32).astype(np.int64)
        if not self.two_sided:
            triangle[~self._front(triangle, directions)] = -1
        second, third = np.moveaxis(hits["primitive_uvs"].numpy(), -1, 0)
        return hits["t_hit"].numpy(), triangle, np.stack([1 - second - third, second, third], axis=-1)

    def _front(self, triangle: Int64Array, directions: Float32Array) -> BoolArray:
        towards: BoolArray = np.einsum("...k,...k->...", self.normals[triangle], directions) < 0
        return towards & (triangle >= 0)


def check_mesh(truth: GroundTruth, name: str) -> None:
    """Raises BadInput for a mesh without faces, or one that cannot be a place in metres."""
    if not len(truth.triangles):
        raise BadInput(f"{name} has no faces: a cloud of points hides nothing, give a triangle mesh")
    a, b, c = truth.vertices[truth.triangles].astype(np.float64).transpose(1, 0, 2)
    if not np.cross(b - a, c - a).any():
        raise BadInput(f"{name} has no face with any area: give a mesh with triangles")
    if not (truth.instances > 0).any():
        raise BadInput(f"{name} has no labelled vertex: all belong to nobody")
    used = truth.vertices[np.unique(truth.triangles)]
    if not np.isfinite(used).all():
        raise BadInput(f"{name} has vertices that are no finite numbers: remove them and the faces at them")
    extent = float(np.ptp(used, axis=0).max())
    if _EXTENT_M[0] <= extent <= _EXTENT_M[1]:
        return
    units = [(unit, scale) for unit, scale in _UNITS.items() if 2 <= extent * scale <= 60]
    fix = f"if these are {units[0][0]}, add --mesh-scale {units[0][1]:g}" if units else "scale it with --mesh-scale"
    raise BadInput(f"{name} is {extent:,.5g} units across, which no place is in metres: {fix}")


def upright_surface(truth: GroundTruth, upright_from_mesh: Float64Array) -> ScannedSurface:
    """The surface of a truth, in the frame that a (4, 4) transform takes it to."""
    vertices = transform_points(upright_from_mesh, truth.vertices.astype(np.float64)).astype(np.float32)
    return ScannedSurface.of(vertices, truth.triangles, truth.instances, truth.colors)


def _cross(vertices: Float32Array, triangles: Int32Array) -> Float64Array:
    a, b, c = (vertices[triangles[:, k]].astype(np.float64) for k in range(3))
    return np.cross(b - a, c - a)


def _vertex_normals(count: int, triangles: Int32Array, weighted: Float64Array) -> Float64Array:
    sums = [np.bincount(triangles.ravel(), np.repeat(column, 3), count) for column in weighted.T]
    normals = np.stack(sums, axis=1)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)


def _painted(vertices: Float32Array, triangles: Int32Array, normals: Float64Array, instances: Int32Array) -> Uint8Array:
    """A pale colour for each instance, lit along z and a little from the side."""
    known, where = np.unique(instances, return_inverse=True)
    hues = np.stack([np.random.default_rng(max(int(i), 0)).uniform(110, 235, 3) for i in known])[where]
    of_vertex = _vertex_normals(len(vertices), triangles, normals)
    light = 0.75 + of_vertex @ np.array([0.08, 0.05, 0.15])
    return (hues * light[:, None]).clip(0, 255).astype(np.uint8)
