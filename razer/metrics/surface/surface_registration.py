"""Registration of two surfaces that lie near each other: point-to-plane ICP with a robust kernel, kept only if it fits
better (Chen and Medioni 1992; Tukey's biweight)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from razer.arrays import Float64Array, FloatArray, IntArray
from razer.metrics.surface.surface_distance import TriangleSurface

MAX_MOVE_M = 0.10  # twice the F-score's limit: whatever lies farther apart is no matter of refinement
_CUT_M = 0.10  # distances beyond count as this one: surface that the other map lacks says nothing of how they lie
_MIN_GAIN, _MIN_GAIN_M = 0.01, 1e-5  # of the fit, its share and metres: less is chance, and rounding
_REACHES_M = (0.10, 0.05, 0.05)  # how far apart partners may be, coarse to fine
_ROUNDS = 10  # for each reach; half as many are enough in practice
_MIN_COSINE = 0.7  # between normals of partners: the two sides of a wall are none
_MIN_PARTNERS = 300  # fewer hardly fix six unknowns
_DAMPING = 0.003  # of the points' weight: directions that the surface leaves open stay as they are
_MAX_POINTS = 20_000
_CONVERGED_M = 1e-5


@dataclass(frozen=True, slots=True)
class SurfaceRegistration:
    """motion (4, 4) that moves the source onto the target, the identity where it was not kept, and why not (None where
    it was); fit_before_m and fit_after_m: mean distances between both surfaces, each cut off at 10 cm, as they lay and
    as the motion found would put them; moved_m and moved_deg: how far that moves the source's points (root mean
    square), and by which angle."""

    motion: Float64Array
    rejected: str | None
    fit_before_m: float | None = None
    fit_after_m: float | None = None
    moved_m: float | None = None
    moved_deg: float | None = None


@dataclass(frozen=True)
class Surface:
    """Vertices (V, 3), metres, and triangles (T, 3) of their numbers."""

    vertices: FloatArray
    triangles: IntArray

    def normals(self) -> Float64Array:
        """Unit normals (V, 3) of the vertices, weighted by area; 0 where a vertex has no triangle."""
        corners = np.asarray(self.vertices, np.float64)[self.triangles]
        of_triangles = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        numbers, doubled_areas = self.triangles.ravel(), np.repeat(of_triangles, 3, axis=0)
        sums = [np.bincount(numbers, doubled_areas[:, axis], len(self.vertices)) for axis in range(3)]
        normals = np.stack(sums, axis=1)
        return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)


def register_surfaces(source: Surface, target: Surface) -> SurfaceRegistration:
    """Move a surface onto another that it lies near to.

    Half of a random sample of the vertices is registered, the other half judges: the motion is kept only if the
    surfaces fit better with it, and if it moves the source by MAX_MOVE_M at most."""
    if not len(source.triangles) or not len(target.triangles):
        return SurfaceRegistration(np.eye(4), "a map without surface has nothing to refine by")
    rows = np.random.default_rng(0).permutation(len(source.vertices))[: 2 * _MAX_POINTS]
    motion = _icp(source, rows[::2], target)
    if motion is None:
        return SurfaceRegistration(np.eye(4), "the surfaces have too little in common")
    fit = _Fit(source, rows[1::2], target)
    before_m, after_m = fit(np.eye(4)), fit(motion)
    points = np.asarray(source.vertices, np.float64)[rows]
    moved_m = _root_mean_square(points @ motion[:3, :3].T + motion[:3, 3] - points)
    moved_deg = float(np.degrees(Rotation.from_matrix(motion[:3, :3]).magnitude()))
    rejected = _why_rejected(before_m, after_m, moved_m)
    return SurfaceRegistration(
        motion if rejected is None else np.eye(4), rejected, before_m, after_m, moved_m, moved_deg
    )


def _why_rejected(before_m: float, after_m: float, moved_m: float) -> str | None:
    if moved_m > MAX_MOVE_M:
        return f"it would move the map by {100 * moved_m:.0f} cm, more than {100 * MAX_MOVE_M:.0f} cm"
    if before_m - after_m <= max(_MIN_GAIN * before_m, _MIN_GAIN_M):
        return "the surfaces would not fit better"
    return None


def _icp(source: Surface, rows: IntArray, target: Surface) -> Float64Array | None:
    """The motion (4, 4) of the source's vertices `rows` onto the target; None where too few of them have a partner."""
    points, normals = np.asarray(source.vertices, np.float64)[rows], source.normals()[rows]
    vertices, target_normals = np.asarray(target.vertices, np.float64), target.normals()
    tree, motion = cKDTree(vertices), np.eye(4)
    for reach_m in _REACHES_M:
        for _ in range(_ROUNDS):
            placed = points @ motion[:3, :3].T + motion[:3, 3]
            distances_m, nearest = tree.query(placed, distance_upper_bound=reach_m)
            has_partner = np.flatnonzero(np.isfinite(distances_m))
            facing = target_normals[nearest[has_partner]]
            alike = ((normals[has_partner] @ motion[:3, :3].T) * facing).sum(axis=1) >= _MIN_COSINE
            chosen = has_partner[alike]
            if len(chosen) < _MIN_PARTNERS:
                return None
            step = _step(placed[chosen], vertices[nearest[chosen]], facing[alike], reach_m)
            motion = step @ motion
            if _root_mean_square(placed @ step[:3, :3].T + step[:3, 3] - placed) < _CONVERGED_M:
                break
    return motion


def _step(points: Float64Array, partners: Float64Array, normals: Float64Array, reach_m: float) -> Float64Array:
    """The small motion (4, 4) that brings points (N, 3) nearest to the planes through their partners, by one damped
    Gauss-Newton step; planes farther than half of the reach do not pull."""
    centre = points.mean(axis=0)
    offsets_m = ((partners - points) * normals).sum(axis=1)
    weights = np.maximum(1 - (offsets_m / (reach_m / 2)) ** 2, 0) ** 2
    arms = points - centre
    radius_m = max(_root_mean_square(arms), 1e-6)
    jacobian = np.concatenate([np.cross(arms / radius_m, normals), normals], axis=1)
    information = jacobian.T @ (weights[:, None] * jacobian) + _DAMPING * max(weights.sum(), 1.0) * np.eye(6)
    change = np.linalg.solve(information, jacobian.T @ (weights * offsets_m))
    step = np.eye(4)
    step[:3, :3] = Rotation.from_rotvec(change[:3] / radius_m).as_matrix()
    step[:3, 3] = centre + change[3:] - step[:3, :3] @ centre
    return step


class _Fit:
    """The mean distance, cut off, of a sample of either surface from the other."""

    def __init__(self, source: Surface, rows: IntArray, target: Surface) -> None:
        targets = np.random.default_rng(1).permutation(len(target.vertices))[:_MAX_POINTS]
        self._source_points = np.asarray(source.vertices, np.float64)[rows]
        self._target_points = np.asarray(target.vertices, np.float64)[targets]
        self._source, self._target = (TriangleSurface(one.vertices, one.triangles) for one in (source, target))

    def __call__(self, motion: Float64Array) -> float:
        there = self._source_points @ motion[:3, :3].T + motion[:3, 3]
        back = (self._target_points - motion[:3, 3]) @ motion[:3, :3]
        distances_m = (self._target.distances(there), self._source.distances(back))
        return float(np.mean([np.minimum(one, _CUT_M).mean() for one in distances_m]))


def _root_mean_square(offsets: FloatArray) -> float:
    return float(np.sqrt((offsets**2).sum(axis=1).mean()))
