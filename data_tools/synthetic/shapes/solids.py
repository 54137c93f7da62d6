"""Boxes and surfaces of revolution: closed solids made of quadrilaterals with texture coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from razer.arrays import Float64Array

Colour = tuple[float, float, float]
Point = tuple[float, float, float]
Glow = Literal["", "sky", "lamp", "screen"]


@dataclass(frozen=True, slots=True)
class Material:
    """A grey texture between two colours (0-255): `texture` is a name of textures.PAINTERS, tiled every `tile_m`;
    `glow` is what shines by itself, if it does."""

    texture: str
    dark: Colour
    light: Colour
    tile_m: float = 2.0
    glow: Glow = ""


@dataclass(frozen=True, slots=True)
class Solid:
    """Planar quadrilaterals of one material: quads (Q, 4, 3) in metres, counter-clockwise from outside,
    where two corners may coincide; uv (Q, 4, 2) texture coordinates in metres."""

    quads: Float64Array
    uv: Float64Array
    material: Material

    def __post_init__(self) -> None:
        if self.quads.shape[1:] != (4, 3) or self.uv.shape != (*self.quads.shape[:2], 2):
            raise ValueError(f"quads {self.quads.shape} and uv {self.uv.shape} do not belong together")

    def moved(self, world_from_local: Float64Array) -> Solid:
        """The same solid after a rigid (4, 4) transform."""
        quads = self.quads @ world_from_local[:3, :3].T + world_from_local[:3, 3]
        return replace(self, quads=quads)


def quad_normals(quads: Float64Array) -> Float64Array:
    """Outward unit normals (Q, 3) of planar quads (Q, 4, 3), from their diagonals."""
    normals = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


# Corners of a box as (x, y, z) choices of low (0) and high (1), counter-clockwise from outside.
BOX_FACES = np.array(
    [
        [(0, 1, 0), (0, 0, 0), (0, 0, 1), (0, 1, 1)],
        [(1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)],
        [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)],
        [(1, 1, 0), (0, 1, 0), (0, 1, 1), (1, 1, 1)],
        [(0, 1, 0), (1, 1, 0), (1, 0, 0), (0, 0, 0)],
        [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)],
    ]
)


def box(low: Point, high: Point, material: Material) -> Solid:
    """The axis-aligned box between two corners, in metres."""
    quads = np.where(BOX_FACES == 0, np.asarray(low, float), np.asarray(high, float))
    # Every face gets its own piece of the texture, so that the faces do not look alike.
    shift = _texture_shift(quads.mean(axis=1))
    return Solid(quads, plane_uv(quads) + shift[:, None], material)


def lathe(
    profile: Sequence[tuple[float, float]], material: Material, at: tuple[float, float] = (0.0, 0.0), sides: int = 24
) -> Solid:
    """A surface of revolution about the vertical.

    Args:
        profile: (radius, height) points in metres, from the bottom over the outside to the top.
        material: of its faces.
        at: (x, y) of the axis, metres.
        sides: how many faces go round.
    """
    radii, heights = np.array(profile, float).T
    angles = np.linspace(0, 2 * np.pi, sides + 1)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    grid = np.concatenate(
        [radii[:, None, None] * ring + at, np.broadcast_to(heights[:, None, None], (len(radii), sides + 1, 1))], axis=2
    )
    length = np.concatenate([[0], np.cumsum(np.hypot(np.diff(radii), np.diff(heights)))])
    around = np.broadcast_to(angles * radii.max(), (len(radii), sides + 1))
    uv = np.stack([around, np.broadcast_to(length[:, None], around.shape)], axis=2)
    quads = _cells(grid)
    flat = quads[..., 2].max(axis=1) - quads[..., 2].min(axis=1) < 1e-9
    uv_cells = np.where(flat[:, None, None], quads[..., :2], _cells(uv))
    shift = _texture_shift(np.array([[*at, heights.sum() + radii.max()]]))
    return Solid(quads, uv_cells + shift[:, None], material)


def _cells(grid: Float64Array) -> Float64Array:
    """The cells of an (A, B, C) grid of points as (Q, 4, C), counter-clockwise."""
    corners = [grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]]
    return np.stack(corners, axis=2).reshape(-1, 4, grid.shape[2])


def plane_uv(quads: Float64Array) -> Float64Array:
    """Texture coordinates (Q, 4, 2) in metres along the first and the last edge of planar quads (Q, 4, 3)."""
    u = quads[:, 1] - quads[:, 0]
    v = quads[:, 3] - quads[:, 0]
    axes = np.stack([w / np.linalg.norm(w, axis=1, keepdims=True) for w in (u, v)], axis=1)
    return np.einsum("qkc,qac->qka", quads - quads[:, :1], axes)


def _texture_shift(centers: Float64Array) -> Float64Array:
    return np.stack([centers @ (7.13, 3.77, 5.19), centers @ (2.31, 9.71, 4.57)], axis=1) % 4.0
