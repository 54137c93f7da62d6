"""A hand-held walk through a scan that looks at all of it and keeps out of furniture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import open3d as o3d

from data_tools.synthetic.camera.camera_path import EYE_M
from data_tools.synthetic.camera.walk import Station, usual_frames, walk
from data_tools.synthetic.layout.free_space import CELL_M, EmptyCells, FreeSpace
from data_tools.synthetic.scans.surface import ScannedSurface, upright_surface
from data_tools.synthetic.scans.view_planning import View, plan_views
from data_tools.synthetic.scans.walkable import GROUNDS, walkable_cells
from data_tools.truth.ground_truth import GroundTruth
from razer.arrays import Float64Array
from razer.errors import BadInput

NEAREST_M = 0.3
"""No camera comes nearer to any surface."""
# Kept on the plan, in the order in which they are tried: rounded corners and the hand come a little nearer.
_CLEAR_M = (0.34, 0.4, 0.5, 0.6)
_LEAST_M2 = 0.5
_STRIDE_M, _TURN_DEG, _STAY = 0.15, 8.0, 4
_AHEAD_M = 1.5
_FACING_RAYS, _ONE_SIDED = 400, 0.75


@dataclass(frozen=True, slots=True)
class ScanWalk:
    """The stations of a walk through an upright surface with its floor at z = 0, whose faces are turned to the walk;
    the transform (4, 4) from the mesh to it; and on which of GROUNDS the walk leads."""

    stations: tuple[Station, ...]
    surface: ScannedSurface
    upright_from_mesh: Float64Array
    ground: str


def plan_walk(truth: GroundTruth, transforms: Sequence[Float64Array], seed: int) -> ScanWalk:
    """A walk past views of all that can be seen of a labelled surface, never nearer than NEAREST_M to it, by the first
    of some transforms to z up in which a person could walk on its floor, or else by the first, above what is there;
    raises BadInput where there is no room for one."""
    likeliest = transforms[0]
    for upright, ground in [*((each, GROUNDS[0]) for each in transforms), *((likeliest, g) for g in GROUNDS[1:])]:
        surface = upright_surface(truth, upright)
        if (found := _walk_on(walkable_cells(surface, ground), surface, seed)) is not None:
            return ScanWalk(*found, upright, ground)
    raise BadInput(
        f"there is no free floor where a camera could be carried {NEAREST_M:g} m from everything: "
        "is --up right, and the mesh in metres (--mesh-scale)?"
    )


def _walk_on(
    cells: EmptyCells, surface: ScannedSurface, seed: int
) -> tuple[tuple[Station, ...], ScannedSurface] | None:
    for clear_m in _CLEAR_M:
        if (space := _roomy(cells, clear_m)) is not None:
            faced = _turned_to_room(surface, space)
            stations = _past(plan_views(faced, space, seed), space)
            if len(stations) > 1 and nearest_m(faced, walk(stations, usual_frames(stations), seed)) >= NEAREST_M:
                return tuple(stations), faced
    return None


def nearest_m(surface: ScannedSurface, poses: Float64Array) -> float:
    """How near the camera comes to the surface, metres; poses (N, 4, 4) in its frame."""
    centers = np.ascontiguousarray(poses[:, :3, 3], np.float32)
    return float(surface.scene.compute_distance(o3d.core.Tensor.from_numpy(centers)).numpy().min())


def _roomy(cells: EmptyCells, clear_m: float) -> FreeSpace | None:
    """The largest free part, where it is large enough to walk in."""
    try:
        space = FreeSpace(cells, clear_m=clear_m)
    except ValueError:
        return None
    return space if len(space.places) * CELL_M**2 >= _LEAST_M2 else None


def _turned_to_room(surface: ScannedSurface, space: FreeSpace) -> ScannedSurface:
    """The surface with the sides that one sees from free places as its fronts; two-sided where they do not agree."""
    rng = np.random.default_rng(0)
    places = space.places[rng.integers(len(space.places), size=_FACING_RAYS)]
    eyes = np.column_stack([places, np.full(len(places), EYE_M)]).astype(np.float32)
    rays = rng.standard_normal(eyes.shape).astype(np.float32)
    met = surface.scene.cast_rays(o3d.core.Tensor.from_numpy(np.hstack([eyes, rays])))["primitive_ids"].numpy()
    hit = met.view(np.int32) >= 0
    front = np.einsum("nk,nk->n", surface.normals[met[hit]], rays[hit]) < 0
    share = float(front.mean()) if hit.any() else 1.0
    if share < 1 - _ONE_SIDED:
        return surface.turned()
    return surface if share > _ONE_SIDED else surface.seen_from_both_sides()


def _past(views: list[View], space: FreeSpace) -> list[Station]:
    """Stations along routes from view to view, turning on the way, with a stay at each."""
    stations, heading, pitch = list[Station](), 0.0, 0.0
    ordered = _tour(views, space)
    place = np.array(ordered[0].place) if ordered else np.zeros(2)
    heading, pitch = (ordered[0].heading, ordered[0].pitch) if ordered else (0.0, 0.0)
    for view in ordered:
        turn = (view.heading - heading + np.pi) % (2 * np.pi) - np.pi
        route = _route(space, place, np.array(view.place), int(np.ceil(abs(np.degrees(turn)) / _TURN_DEG)) + 1)
        for share, point in zip(np.linspace(0, 1, len(route)), route, strict=True):
            stations.append(_station(point, heading + share * turn, pitch + share * (view.pitch - pitch)))
        stations += [stations[-1]] * _STAY
        place, heading, pitch = np.array(view.place), view.heading, view.pitch
    return stations


def _route(space: FreeSpace, start: Float64Array, end: Float64Array, least: int) -> Float64Array:
    """Points (K, 2) on the way between two places, a stride apart or `least` of them."""
    way = space.route(start, end)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))])
    even = np.linspace(0, along[-1], max(2, least, int(np.ceil(along[-1] / _STRIDE_M)) + 1))
    return np.stack([np.interp(even, along, way[:, k]) for k in range(2)], axis=1)


def _station(point: Float64Array, heading: float, pitch: float) -> Station:
    x, y = float(point[0]), float(point[1])
    ahead = _AHEAD_M * np.array([np.cos(heading), np.sin(heading), np.tan(pitch)])
    return Station((x, y, EYE_M), (x + float(ahead[0]), y + float(ahead[1]), EYE_M + float(ahead[2])))


def _tour(views: list[View], space: FreeSpace) -> list[View]:
    """The views in an order in which one walks and turns little: nearest neighbour, then 2-opt."""
    if len(views) < 3:
        return views
    ways = space.ways(np.array([view.place for view in views]))
    headings = np.array([view.heading for view in views])
    turns = np.abs((headings[:, None] - headings + np.pi) % (2 * np.pi) - np.pi)
    cost = np.maximum(ways / 0.45, turns / np.radians(54.0))
    order, left = [0], set(range(1, len(views)))
    while left:
        order.append(min(left, key=lambda k: float(cost[order[-1], k])))
        left.remove(order[-1])
    return [views[k] for k in _two_opt(order, cost)]


def _two_opt(order: list[int], cost: Float64Array) -> list[int]:
    """The order with stretches turned round as long as that makes it shorter."""
    improved = True
    while improved:
        improved = False
        for i in range(len(order) - 2):
            for j in range(i + 2, len(order)):
                a, b, c = order[i], order[i + 1], order[j]
                after = cost[c, order[j + 1]] - cost[b, order[j + 1]] if j + 1 < len(order) else 0.0
                if cost[a, c] - cost[a, b] - after < -1e-9:
                    order[i + 1 : j + 1] = order[i + 1 : j + 1][::-1]
                    improved = True
    return order
