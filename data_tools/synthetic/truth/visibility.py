"""Visibility of surface points in a recording: in view, facing the camera, not occluded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import open3d as o3d

from data_tools.synthetic.truth.tessellation import SampledSurface
from razer.arrays import BoolArray, Float32Array, Float64Array, Int64Array
from razer.frame import Intrinsics
from razer.geometry import inverse, project, transform_points

# Rays start this much before a vertex: more than rounding, less than the thinnest plate that hides a wall.
TOLERANCE_M = 0.001
_CELL_M = 0.25
_GOLDEN = 0.6180339887


class Occluder(Protocol):
    """What rays may meet: Open3D's RaycastingScene is one."""

    def test_occlusions(self, rays: o3d.core.Tensor, tnear: float = 0.0, tfar: float = np.inf) -> o3d.core.Tensor:
        """Whether each ray (..., 6) meets something between tnear and tfar, in units of its direction."""


@dataclass(frozen=True, slots=True)
class Viewpoint:
    """One frame's pose world_from_camera (4, 4) and what could hide a point from it."""

    world_from_camera: Float64Array
    scene: Occluder


@dataclass(frozen=True, slots=True)
class CameraView:
    """A camera and the depths along its axis, least and most in metres, at which it measures."""

    intrinsics: Intrinsics
    range_m: tuple[float, float]


def visible_vertices(
    surface: SampledSurface, viewpoints: Sequence[Viewpoint], view: CameraView, min_views: int, since: Int64Array
) -> BoolArray:
    """Whether each vertex (V,) is visible from enough viewpoints.

    It is from one if it lies in the image within range, faces the camera, and has nothing more than TOLERANCE_M
    before it.

    Args:
        surface: its vertices (V, 3) and normals.
        viewpoints: the frames of the recording.
        view: the camera, and the depths at which it measures.
        min_views: how many viewpoints must see a vertex.
        since: (V,) the first viewpoint that counts for each vertex.
    """
    faced = np.flatnonzero(_ever_faced(surface, viewpoints))
    cells = _Cells.of(surface.vertices[faced])
    number_of = faced[cells.order]
    vertices = surface.vertices[number_of].astype(np.float32)
    normals = surface.normals[number_of].astype(np.float32)
    first = since[number_of]
    views = np.zeros(len(number_of), np.int32)
    # Very different views first: most vertices are soon done and are not tested again.
    for number in np.argsort(np.arange(len(viewpoints)) * _GOLDEN % 1):
        viewpoint = viewpoints[number]
        near = cells.candidates(viewpoint.world_from_camera, view)
        near = near[(views[near] < min_views) & (first[near] <= number)]
        near = near[_in_view(vertices[near], normals[near], viewpoint.world_from_camera, view)]
        views[near[~_hidden(vertices[near], viewpoint)]] += 1
    often = np.zeros(len(surface.vertices), np.bool_)
    often[number_of] = views >= min_views
    return often


@dataclass(frozen=True, slots=True)
class _Cells:
    """Vertices sorted by cubes of _CELL_M: order (V,), the cubes' centres (C, 3), and where in the order each
    cube's vertices start and how many they are, (C,)."""

    order: Int64Array
    centers: Float64Array
    starts: Int64Array
    counts: Int64Array

    @classmethod
    def of(cls, vertices: Float64Array) -> _Cells:
        keys = np.floor(vertices / _CELL_M).astype(np.int64)
        low = keys.min(axis=0)
        shape = tuple(keys.max(axis=0) - low + 1)
        flat = np.ravel_multi_index(tuple((keys - low).T), shape)
        cells, starts, counts = np.unique(np.sort(flat), return_index=True, return_counts=True)
        centers = (np.stack(np.unravel_index(cells, shape), axis=1) + low + 0.5) * _CELL_M
        return cls(np.argsort(flat, kind="stable"), centers, starts, counts)

    def candidates(self, world_from_camera: Float64Array, view: CameraView) -> Int64Array:
        """Places in the order of all vertices in cubes that may be in view."""
        maybe = self._maybe_in_view(world_from_camera, view)
        starts, counts = self.starts[maybe], self.counts[maybe]
        before = np.cumsum(counts) - counts
        return np.arange(counts.sum()) + np.repeat(starts - before, counts)

    def _maybe_in_view(self, world_from_camera: Float64Array, view: CameraView) -> BoolArray:
        """Whether any point of each cube (C,) may project into the image within range; never wrongly no."""
        camera = view.intrinsics
        x, y, z = transform_points(inverse(world_from_camera), self.centers).T
        radius = _CELL_M * np.sqrt(3) / 2
        maybe = (z > view.range_m[0] - radius) & (z < view.range_m[1] + radius)
        for along, size, focal, center in (
            (x, camera.width, camera.fx, camera.cx),
            (y, camera.height, camera.fy, camera.cy),
        ):
            low, high = (-0.5 - center) / focal, (size - 0.5 - center) / focal
            maybe &= (along - low * z) > -radius * np.hypot(1, low)
            maybe &= (high * z - along) > -radius * np.hypot(1, high)
        return maybe


def _ever_faced(surface: SampledSurface, viewpoints: Sequence[Viewpoint]) -> BoolArray:
    """Whether a camera may lie on the outer side of each vertex's tangent plane; never wrongly no."""
    centers = np.array([viewpoint.world_from_camera[:3, 3] for viewpoint in viewpoints])
    farthest = np.where(surface.normals > 0, centers.max(axis=0), centers.min(axis=0))
    return np.einsum("vk,vk->v", surface.normals, farthest - surface.vertices) > 0


def _in_view(
    vertices: Float32Array, normals: Float32Array, world_from_camera: Float64Array, view: CameraView
) -> BoolArray:
    """Whether vertices face the camera and project into its image, within range."""
    camera = view.intrinsics
    away = vertices - world_from_camera[:3, 3].astype(np.float32)
    in_camera = away @ world_from_camera[:3, :3].astype(np.float32)
    u, v, z = project(in_camera.astype(np.float64), camera.matrix)
    with np.errstate(invalid="ignore"):
        inside = (z >= view.range_m[0]) & (z <= view.range_m[1])
        inside &= (u > -0.5) & (u < camera.width - 0.5) & (v > -0.5) & (v < camera.height - 0.5)
    return inside & (np.einsum("vk,vk->v", normals, away) < 0)


def _hidden(vertices: Float32Array, viewpoint: Viewpoint) -> BoolArray:
    """Whether something lies between the camera and each vertex, more than the tolerance before it."""
    rays = np.empty((len(vertices), 6), np.float32)
    rays[:, :3] = viewpoint.world_from_camera[:3, 3]
    towards = vertices - rays[:, :3]
    rays[:, 3:] = towards * (1 - TOLERANCE_M / np.linalg.norm(towards, axis=1, keepdims=True))
    return viewpoint.scene.test_occlusions(o3d.core.Tensor.from_numpy(rays), tfar=1.0).numpy().astype(bool)
