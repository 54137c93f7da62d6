"""Radiosity (Goral et al. 1984) by gathering: each sample of the faces collects what its hemisphere of rays meets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import open3d as o3d

from data_tools.synthetic.light.face_grid import FaceGrid
from razer.arrays import BoolArray, Float32Array, Float64Array, Int32Array

_RAYS = 32
_BOUNCES = 4
_CHUNK = 20_000
_GAP_M = 0.02
_OUTSIDE, _INSIDE = -1, -2


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The node that each of a node's rays meets, (N, R) int32: _OUTSIDE where there is nothing, _INSIDE where it meets
    the back of a face, and so starts within a solid, or something so near that nobody looks in between."""

    met: Int32Array

    @classmethod
    def of(cls, grid: FaceGrid, quads: Float64Array, scene: o3d.t.geometry.RaycastingScene) -> Surroundings:
        """Cast rays, more of them the nearer to the normal, as light weighs; the scene has two triangles a quad."""
        points, face = grid.points(quads).astype(np.float32), grid.face
        normals = grid.normals.astype(np.float32)
        pattern = _pattern(grid)
        met = np.empty((len(points), _RAYS), np.int32)
        for start in range(0, len(points), _CHUNK):
            part = slice(start, start + _CHUNK)
            met[part] = _cast(grid, scene, points[part], normals[face[part]], pattern[part])
        return cls(met)

    @property
    def buried(self) -> BoolArray:
        """Which nodes (N,) are mostly within solids or behind things on a wall; nobody sees how they are lit."""
        buried: BoolArray = (self.met == _INSIDE).mean(axis=1) > 0.5
        return buried


def _cast(
    grid: FaceGrid,
    scene: o3d.t.geometry.RaycastingScene,
    points: Float32Array,
    normals: Float32Array,
    pattern: Float32Array,
) -> Int32Array:
    rays = np.empty((len(points), _RAYS, 6), np.float32)
    rays[..., :3], rays[..., 3:] = points[:, None], _hemispheres(normals, pattern)
    hit = scene.cast_rays(o3d.core.Tensor.from_numpy(rays))
    triangle = hit["primitive_ids"].numpy().view(np.int32)
    met = np.full(triangle.shape, _OUTSIDE, np.int32)
    there = triangle >= 0
    face = triangle[there] >> 1
    origin, direction = np.split(rays[there], 2, axis=1)
    nodes = grid.nearest_node(face, origin + hit["t_hit"].numpy()[there][:, None] * direction)
    back = (direction * grid.normals.astype(np.float32)[face]).sum(axis=1) > 0
    met[there] = np.where(back | (hit["t_hit"].numpy()[there] < _GAP_M), _INSIDE, nodes)
    return met


def _pattern(grid: FaceGrid) -> Float32Array:
    """A number (N,) in 0..1 for each node, nine different ones in each square of three by three nodes, whose average
    thus is as even as one node's with nine times as many rays."""
    column, row = (grid.cell() % 3).T
    order = np.array([[0, 5, 7], [3, 8, 1], [6, 2, 4]])
    return ((order[column, row] + 0.5) / 9).astype(np.float32)


def _hemispheres(normals: Float32Array, pattern: Float32Array) -> Float32Array:
    """Unit vectors (N, R, 3) about the normals, as dense as the cosine: one spiral, turned and pushed outwards by the
    pattern (N,)."""
    steps = np.arange(_RAYS) + pattern[:, None]
    turn = steps * np.pi * (3 - np.sqrt(5))
    out = np.sqrt(steps / _RAYS)
    local = np.stack([out * np.cos(turn), out * np.sin(turn), np.sqrt(1 - out**2)], axis=2).astype(np.float32)
    other = np.where(np.abs(normals[:, 2:]) < 0.9, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)).astype(np.float32)
    across = np.cross(other, normals)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    frames = np.stack([across, np.cross(normals, across), normals], axis=1)
    return local @ frames.astype(np.float32)


def irradiance(
    around: Surroundings, emitted: Float32Array, reflectance: Float32Array, outside: tuple[float, float, float]
) -> Float32Array:
    """The light (N, 3) that falls on each node, in units of a sky of radiance 1 all round.

    Args:
        around: what each node sees.
        emitted: (N, 3) radiance of the nodes.
        reflectance: (N, 3) share of light that they send back.
        outside: radiance where there is nothing.
    """
    light = np.zeros_like(emitted)
    for _ in range(_BOUNCES):
        light = gathered(around, emitted + reflectance * light, outside)
    return light


def gathered(around: Surroundings, radiance: Float32Array, outside: tuple[float, float, float]) -> Float32Array:
    """The mean (N, 3) of what the rays of each node meet, where the nodes have this radiance (N, 3)."""
    # The last two rows are what negative numbers index: the inside of a solid, and nothing.
    rows = np.concatenate([radiance, np.zeros((1, 3)), [outside]]).astype(np.float32)
    light = np.empty_like(radiance)
    for start in range(0, len(light), _CHUNK):
        met = around.met[start : start + _CHUNK]
        counted = np.maximum((met != _INSIDE).sum(axis=1), 1)
        light[start : start + _CHUNK] = rows[met].sum(axis=1) / counted[:, None]
    return light
