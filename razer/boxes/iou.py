"""Exact IoU of oriented boxes by polygon clipping, for many pairs at once.

By the divergence theorem a convex body's volume is 1/3 of the sum over its faces of area times the face
plane's distance from any fixed point. The faces of an intersection are the faces of either box clipped by
the other, so clipping twelve rectangles by six half-spaces each (Sutherland and Hodgman 1974) is enough.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from razer.arrays import BoolArray, Float64Array, IndexArray
from razer.boxes.oriented_box import OrientedBox

MAX_CORNERS = 10  # a rectangle clipped by six half-spaces
# Coplanar faces of both boxes would be counted twice: the second box is shrunk by this share first.
SHRINK = 1e-9


def shared_volumes(first: Sequence[OrientedBox], second: Sequence[OrientedBox]) -> Float64Array:
    """Intersection volumes (N,) in cubic metres of N pairs of boxes."""
    if len(first) == 0:
        return np.zeros(0)
    a, b = _stack(first), _stack(second)
    b = (b[0], b[1], b[2] * (1 - SHRINK))
    # Near a box of the pair every coordinate is small, which keeps the sum of signed volumes accurate.
    origin = np.concatenate([a[0], a[0]])
    boxes, clips = ((np.concatenate(parts) for parts in zip(*pair, strict=True)) for pair in ((a, b), (b, a)))
    volumes = _clipped_faces(tuple(boxes), tuple(clips), origin).reshape(2, -1).sum(axis=0)
    limit = np.minimum(np.prod(2 * a[2], axis=1), np.prod(2 * b[2], axis=1))
    return np.clip(volumes, 0.0, limit)


def box_iou(first: Sequence[OrientedBox], second: Sequence[OrientedBox]) -> Float64Array:
    """Intersection over union (N,) of N pairs; 0 where a box has no volume."""
    shared = shared_volumes(first, second)
    union = _volumes(first) + _volumes(second) - shared
    return np.divide(shared, union, out=np.zeros_like(shared), where=union > 0)


def box_containment(first: Sequence[OrientedBox], second: Sequence[OrientedBox]) -> Float64Array:
    """Intersection over the smaller volume (N,): 1 where one box lies inside the other."""
    shared = shared_volumes(first, second)
    smaller = np.minimum(_volumes(first), _volumes(second))
    return np.divide(shared, smaller, out=np.zeros_like(shared), where=smaller > 0)


def _volumes(boxes: Sequence[OrientedBox]) -> Float64Array:
    return np.array([box.volume for box in boxes])


def _stack(boxes: Sequence[OrientedBox]) -> tuple[Float64Array, Float64Array, Float64Array]:
    centers = np.stack([box.center for box in boxes])
    return centers, np.stack([box.rotation for box in boxes]), np.stack([box.extent / 2 for box in boxes])


def _clipped_faces(box: tuple[Float64Array, ...], clip: tuple[Float64Array, ...], origin: Float64Array) -> Float64Array:
    """Volume (N,) under the faces of `box` that lie inside `clip`, as seen from `origin`."""
    center, rotation, half = box
    polygons, normals = _faces(half)
    world = np.einsum("nij,nfcj->nfci", rotation, polygons) + center[:, None, None]
    local = np.einsum("nji,nfcj->nfci", clip[1], world - clip[0][:, None, None])
    clipped = _clip(local.reshape(-1, 4, 3), np.repeat(clip[2], 6, axis=0)).reshape(len(center), 6, MAX_CORNERS, 3)
    normals_world = np.einsum("nij,fj->nfi", rotation, normals)
    normals_local = np.einsum("nji,nfj->nfi", clip[1], normals_world)
    area = np.einsum("nfi,nfi->nf", _area_vectors(clipped), normals_local)
    distance = np.einsum("nfi,nfi->nf", world[:, :, 0] - origin[:, None], normals_world)
    return (area * distance).sum(axis=1) / 3


def _faces(half: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Corners (N, 6, 4, 3) of the faces, anticlockwise from outside, and outward normals (6, 3)."""
    normals = np.concatenate([np.eye(3), -np.eye(3)])
    corners = []
    for normal in normals:
        axis = int(np.abs(normal).argmax())
        u, v = np.eye(3)[(axis + 1) % 3] * normal[axis], np.eye(3)[(axis + 2) % 3]
        corners.append([normal - u - v, normal + u - v, normal + u + v, normal - u + v])
    return np.array(corners)[None] * half[:, None, None], normals


def _area_vectors(polygons: Float64Array) -> Float64Array:
    """Area times unit normal (..., 3) of planar polygons (..., C, 3)."""
    fan = polygons - polygons[..., :1, :]
    return np.cross(fan[..., 1:-1, :], fan[..., 2:, :]).sum(axis=-2) / 2


def _clip(polygons: Float64Array, half: Float64Array) -> Float64Array:
    """Clip convex polygons (M, 4, 3) by the boxes |x| <= half (M, 3); returned padded to MAX_CORNERS."""
    pad = np.repeat(polygons[:, -1:], MAX_CORNERS - polygons.shape[1], axis=1)
    polygons = np.concatenate([polygons, pad], axis=1)
    for axis in range(3):
        for sign in (1.0, -1.0):
            polygons = _clip_by_plane(polygons, half[:, axis, None] - sign * polygons[:, :, axis])
    return polygons


def _clip_by_plane(polygons: Float64Array, inside: Float64Array) -> Float64Array:
    """Keep the part of each polygon (M, C, 3) where `inside` (M, C), linear along edges, is >= 0."""
    following, inside_next = np.roll(polygons, -1, axis=1), np.roll(inside, -1, axis=1)
    crosses = (inside >= 0) != (inside_next >= 0)
    share = inside / np.where(crosses, inside - inside_next, 1.0)
    crossing = polygons + share[..., None] * (following - polygons)
    points = np.stack([polygons, crossing], axis=2).reshape(len(polygons), -1, 3)
    # Padding repeats a corner: only the last of equal corners counts.
    distinct = (polygons != following).any(axis=2)
    kept = np.stack([(inside >= 0) & distinct, crosses], axis=2).reshape(len(polygons), -1)
    result = np.take_along_axis(points, _padded_columns(kept)[..., None], axis=1)
    result[~kept.any(axis=1)] = 0.0
    return result


def _padded_columns(kept: BoolArray) -> IndexArray:
    """The columns (M, MAX_CORNERS) that are kept in each row, in order."""
    order = np.argsort(~kept, axis=1, kind="stable")[:, :MAX_CORNERS]
    count = kept.sum(axis=1)
    # Repeating the last kept corner adds edges of no length, and so no area.
    last = np.take_along_axis(order, np.maximum(count - 1, 0)[:, None], axis=1)
    return np.where(np.arange(MAX_CORNERS) < count[:, None], order, last)
