"""Ambient occlusion: how much of what lies near hides the open room from each vertex, by rays (Zhukov et al., 1998)."""

from __future__ import annotations

import numpy as np
import open3d as o3d
import open3d.core as o3c

from razer.arrays import Float32Array, Float64Array, Uint8Array
from razer.mesh.labelled_mesh import LabelledMesh
from razer.semantics.normals import sums_at_vertices, vertex_normals

RADIUS_M = 0.7  # what is farther away does not darken
N_RAYS = 24
_LIFT_M = 0.015  # rays start above the surface, which is rough
_VERTICES_AT_ONCE = 40_000
_SMOOTHINGS = 2


def ambient_occlusion(mesh: LabelledMesh) -> Uint8Array:
    """Openness (V,): 255 where no ray of the cosine-weighted hemisphere meets anything within RADIUS_M; a ray that
    does counts the less the farther it goes."""
    if not len(mesh.triangles):
        return np.full(len(mesh.vertices), 255, np.uint8)
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3c.Tensor(np.ascontiguousarray(mesh.vertices, np.float32)),
        o3c.Tensor(np.ascontiguousarray(mesh.triangles, np.uint32)),
    )
    normals = vertex_normals(mesh)
    openness = np.empty(len(mesh.vertices))
    random = np.random.default_rng(0)
    for start in range(0, len(openness), _VERTICES_AT_ONCE):
        part = slice(start, start + _VERTICES_AT_ONCE)
        openness[part] = _openness(scene, mesh.vertices[part], normals[part], random)
    return np.rint(255 * _smoothed(openness, mesh)).astype(np.uint8)


def _openness(
    scene: o3d.t.geometry.RaycastingScene, points: Float32Array, normals: Float64Array, random: np.random.Generator
) -> Float64Array:
    directions = normals[:, None] + _sphere(N_RAYS, random)  # Lambert's cosine law: a point of the sphere on the tip
    directions /= np.linalg.norm(directions, axis=2, keepdims=True).clip(1e-6)
    origins = np.broadcast_to((points + _LIFT_M * normals)[:, None], directions.shape)
    rays = np.concatenate([origins, directions], axis=2).astype(np.float32)
    hit_m = scene.cast_rays(o3c.Tensor(rays))["t_hit"].numpy()
    return (hit_m / RADIUS_M).clip(max=1.0).mean(axis=1)


def _sphere(n: int, random: np.random.Generator) -> Float64Array:
    """n points (n, 3) spread over the unit sphere: a Fibonacci lattice, turned at random."""
    height = 1 - 2 * (np.arange(n) + 0.5) / n
    turn = np.pi * (3 - 5**0.5) * np.arange(n) + random.uniform(0, 2 * np.pi)
    ring = np.sqrt(1 - height**2)
    return np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)


def _smoothed(values: Float64Array, mesh: LabelledMesh) -> Float64Array:
    """Averages over the triangles around each vertex, which take out the noise of few rays."""
    counts = sums_at_vertices(mesh, np.ones((len(mesh.triangles), 1)))[:, 0]
    for _ in range(_SMOOTHINGS):
        of_triangles = values[mesh.triangles].mean(axis=1, keepdims=True)
        sums = sums_at_vertices(mesh, of_triangles)[:, 0]
        values = np.where(counts > 0, sums / counts.clip(1), values)
    return values
