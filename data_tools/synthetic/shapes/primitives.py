"""Closed solids for furniture: blocks, prisms, soft and tapered boxes, tubes, balls, tetrahedra."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise, product

import numpy as np
from numpy.typing import ArrayLike

from data_tools.synthetic.shapes.solids import BOX_FACES, Material, Point, Solid, box, lathe, plane_uv, quad_normals
from data_tools.synthetic.shapes.transforms import turned
from razer.arrays import Float64Array

Rectangle = tuple[float, float, float, float]
_BOW_PARTS = 4


def block(center_x: float, center_y: float, bottom: float, size: Point, material: Material) -> Solid:
    """A box by its size, standing on a height.

    Args:
        center_x: metres.
        center_y: metres.
        bottom: height it stands on, metres.
        size: in x, y and z, metres.
        material: of its faces.
    """
    half_x, half_y = size[0] / 2, size[1] / 2
    low = (center_x - half_x, center_y - half_y, bottom)
    return box(low, (center_x + half_x, center_y + half_y, bottom + size[2]), material)


def legs(width: float, depth: float, height: float, thick: float, material: Material) -> list[Solid]:
    """Four square posts on the floor.

    Args:
        width: between the outer sides in x, metres.
        depth: between the outer sides in y.
        height: metres.
        thick: of a post, metres.
        material: of its faces.
    """
    x, y = (width - thick) / 2, (depth - thick) / 2
    return [block(sx * x, sy * y, 0, (thick, thick, height), material) for sx in (-1, 1) for sy in (-1, 1)]


def tapered(bottom: Rectangle, top: Rectangle, low: float, high: float, material: Material) -> Solid:
    """The hull of two horizontal rectangles.

    Args:
        bottom: (x low, y low, x high, y high), metres.
        top: the same of the upper rectangle.
        low: height where it begins, metres.
        high: height where it ends.
        material: of its faces.
    """
    rectangles = np.array([bottom, top]).reshape(2, 2, 2)
    x, y, z = np.moveaxis(BOX_FACES, -1, 0)
    quads = np.stack([rectangles[z, x, 0], rectangles[z, y, 1], np.array([low, high])[z]], axis=-1)
    return Solid(quads, plane_uv(quads), material)


def prism(outline: ArrayLike, low: float, high: float, material: Material) -> Solid:
    """A convex outline extruded upwards.

    Args:
        outline: (N, 2) convex, counter-clockwise from above, metres.
        low: height where it begins, metres.
        high: height where it ends.
        material: of its faces.
    """
    ring = np.asarray(outline, float)
    closed = np.concatenate([ring, ring[:1]])
    bottom, top = (np.column_stack([closed, np.full(len(closed), z)]) for z in (low, high))
    sides = np.stack([bottom[:-1], bottom[1:], top[1:], top[:-1]], axis=1)
    around = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    uv = np.stack([np.column_stack([around, np.full(len(around), z)]) for z in (low, high)])
    side_uv = np.stack([uv[0, :-1], uv[0, 1:], uv[1, 1:], uv[1, :-1]], axis=1)
    cap = np.array([(0, i, i + 1, min(i + 2, len(ring) - 1)) for i in range(1, len(ring) - 1, 2)])
    caps = np.concatenate([top[cap], bottom[cap[:, ::-1]]])
    return Solid(np.concatenate([sides, caps]), np.concatenate([side_uv, caps[..., :2]]), material)


def bowed(
    width: float, bow: float, thick: float, heights: tuple[float, float], ys: tuple[float, float], material: Material
) -> Solid:
    """An upright panel that is bent in plan like the back of a chair: its middle lies behind its ends.

    Args:
        width: between its ends in x, metres.
        bow: by how much the middle of its front lies further back (-y) than the ends, metres.
        thick: from front to back, metres.
        heights: of its lower and its upper edge, metres.
        ys: of the front of its ends at these heights, metres.
        material: of its faces.
    """
    x = np.linspace(-width / 2, width / 2, _BOW_PARTS + 1)
    front = -bow * (1 - (2 * x / width) ** 2)
    # Rings of the outline at both heights; each cell between two stations is a prism's piece.
    edges = [
        [np.column_stack([x, front + y - back, np.full_like(x, z)]) for back in (0.0, thick)]
        for y, z in zip(ys, heights, strict=True)
    ]
    (low_front, low_back), (high_front, high_back) = edges
    left = [np.stack([low_back[:1], low_front[:1], high_front[:1], high_back[:1]], axis=1)]
    right = [np.stack([low_front[-1:], low_back[-1:], high_back[-1:], high_front[-1:]], axis=1)]
    sheets = [
        np.stack([low_front[1:], low_front[:-1], high_front[:-1], high_front[1:]], axis=1),
        np.stack([low_back[:-1], low_back[1:], high_back[1:], high_back[:-1]], axis=1),
        np.stack([high_back[:-1], high_back[1:], high_front[1:], high_front[:-1]], axis=1),
        np.stack([low_front[:-1], low_front[1:], low_back[1:], low_back[:-1]], axis=1),
    ]
    quads = np.concatenate([*sheets, *(side[:, ::-1] for side in (*left, *right))])
    return Solid(quads, plane_uv(quads), material)


def layered(layers: Sequence[Point], material: Material) -> Solid:
    """Rectangles (half width, half depth, height), centred on the z axis and listed upwards, joined to one solid."""
    signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    rings = np.array([np.column_stack([signs * (x, y), np.full(4, z)]) for x, y, z in layers])
    after = np.roll(rings, -1, axis=1)
    sides = np.stack([rings[:-1], after[:-1], after[1:], rings[1:]], axis=2).reshape(-1, 4, 3)
    quads = np.concatenate([sides, rings[:1, ::-1], rings[-1:]])
    return Solid(quads, plane_uv(quads), material)


def cylinder(radius: float, low: float, high: float, material: Material, sides: int = 12) -> Solid:
    """An upright cylinder about the z axis, with few faces.

    Args:
        radius: metres.
        low: height where it begins, metres.
        high: height where it ends.
        material: of its faces.
        sides: how many faces go round.
    """
    angles = np.arange(sides) * 2 * np.pi / sides
    return prism(radius * np.stack([np.cos(angles), np.sin(angles)], axis=1), low, high, material)


def disc(radius: float, thick: float, at: Point, material: Material, sides: int = 16) -> Solid:
    """A round plate that faces +y.

    Args:
        radius: metres.
        thick: metres.
        at: the centre of its back, metres.
        material: of its faces.
        sides: how many faces go round.
    """
    return turned(cylinder(radius, 0, thick, material, sides), "x", -90, at)


def rounded(low: Point, high: Point, axis: str, bevel: float, material: Material) -> Solid:
    """A box with four bevelled edges.

    Args:
        low: lowest corner, metres.
        high: highest corner.
        axis: x, y or z: along which the cut edges run.
        bevel: by how much they are cut off, metres.
        material: of its faces.
    """
    k = "xyz".index(axis)
    a, b = (k + 1) % 3, (k + 2) % 3
    outline = _octagon((low[a], low[b]), (high[a], high[b]), bevel)
    upright = prism(outline, low[k], high[k], material)
    return replace(upright, quads=np.roll(upright.quads, k + 1, axis=2))


def _octagon(low: tuple[float, float], high: tuple[float, float], bevel: float) -> list[tuple[float, float]]:
    """A rectangle with its corners cut off, against the clock."""
    (u0, v0), (u1, v1) = low, high
    outline = [(u0 + bevel, v0), (u1 - bevel, v0), (u1, v0 + bevel), (u1, v1 - bevel)]
    return [*outline, (u1 - bevel, v1), (u0 + bevel, v1), (u0, v1 - bevel), (u0, v0 + bevel)]


def soft_box(low: Point, high: Point, bevel: Point, material: Material) -> Solid:
    """A box with bevelled edges and corners.

    Args:
        low: lowest corner, metres.
        high: highest corner.
        bevel: by how much edges and corners are cut off along each axis, metres.
        material: of its faces.
    """
    center, half = (np.array(low) + high) / 2, (np.array(high) - low) / 2
    inset = half - bevel

    def corner(signs: Sequence[int], axis: int) -> Float64Array:
        return np.array(signs) * np.where(np.arange(3) == axis, half, inset)

    quads = []
    for axis, side in product(range(3), (-1, 1)):
        around = [(side, -1, -1), (side, 1, -1), (side, 1, 1), (side, -1, 1)]
        quads.append([corner(np.roll(signs, axis).tolist(), axis) for signs in around])
    for axis, first, second in product(range(3), (-1, 1), (-1, 1)):
        one, two = (np.roll((along, first, second), axis).tolist() for along in (-1, 1))
        a, b = (axis + 1) % 3, (axis + 2) % 3
        quads.append([corner(one, a), corner(two, a), corner(two, b), corner(one, b)])
    for signs in product((-1, 1), repeat=3):
        quads.append([corner(signs, axis) for axis in (0, 1, 2, 2)])
    return _star_shaped(np.array(quads) + center, center, material)


def tetrahedron(corners: ArrayLike, material: Material) -> Solid:
    """The solid between four points (4, 3) in metres."""
    points = np.asarray(corners, float)
    faces = points[[(0, 1, 2, 2), (0, 1, 3, 3), (0, 2, 3, 3), (1, 2, 3, 3)]]
    return _star_shaped(faces, points.mean(axis=0), material)


def _star_shaped(quads: Float64Array, center: Float64Array, material: Material) -> Solid:
    """Quads of which the centre sees all, turned to face away from it."""
    inwards = np.einsum("qk,qk->q", quad_normals(quads), quads[:, 0] - center) < 0
    # Reversed, with the doubled corner of a triangle still at the end.
    quads[inwards] = quads[inwards][:, [1, 0, 3, 2]]
    return Solid(quads, plane_uv(quads), material)


def ball(center: Point, radii: Point, material: Material, sides: int = 12, rings: int = 6) -> Solid:
    """An ellipsoid.

    Args:
        center: metres.
        radii: half axes, metres.
        material: of its faces.
        sides: how many faces go round.
        rings: how many faces lie between the poles.
    """
    angles = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)
    profile = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    profile[[0, -1], 0] = 0
    unit = lathe(profile.tolist(), material, sides=sides)
    return replace(unit, quads=unit.quads * radii + center, uv=unit.uv * float(np.mean(radii)))


def beam(start: Point, end: Point, width: float, thick: float, material: Material) -> Solid:
    """A bar of rectangular section between two points.

    Args:
        start: metres.
        end: metres.
        width: of the section, horizontally, metres.
        thick: of the section, across that.
        material: of its faces.
    """
    length = float(np.linalg.norm(np.subtract(end, start)))
    return block(0, 0, 0, (width, thick, length), material).moved(_along(start, end))


def bars(
    points: Sequence[Point], width: float, thick: float, material: Material, *, closed: bool = False
) -> list[Solid]:
    """Beams from each point to the next.

    Args:
        points: metres.
        width: of the section, horizontally, metres.
        thick: of the section, across that.
        material: of its faces.
        closed: another beam from the last point to the first.
    """
    ring = [*points, points[0]] if closed else points
    return [beam(start, end, width, thick, material) for start, end in pairwise(ring)]


def tube(start: Point, end: Point, radius: float, material: Material, sides: int = 6) -> Solid:
    """A rod between two points.

    Args:
        start: metres.
        end: metres.
        radius: metres.
        material: of its faces.
        sides: how many faces go round.
    """
    length = float(np.linalg.norm(np.subtract(end, start)))
    return cylinder(radius, 0, length, material, sides).moved(_along(start, end))


def _along(start: Point, end: Point) -> Float64Array:
    """The rigid transform that takes the z axis to the line from start to end and keeps x horizontal."""
    axis = np.subtract(end, start) / np.linalg.norm(np.subtract(end, start))
    across = np.array([1.0, 0, 0]) if abs(axis[2]) > 0.999 else np.cross((0, 0, 1), axis)
    across = across - (across @ axis) * axis
    across /= np.linalg.norm(across)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([across, np.cross(axis, across), axis], axis=1)
    pose[:3, 3] = start
    return pose
