"""Colours of the vertices of a PLY mesh, by whatever names and in whatever type it has them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from data_tools.truth.ply import Ply
from razer.arrays import Float64Array, Uint8Array

_NAMES = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"), ("r", "g", "b"))


def vertex_colors(mesh: Ply) -> Uint8Array | None:
    """Colours (V, 3) of vertices, or means of the colours of the faces round them; None where there are none. Floats
    are shares of 1 unless one is above 1, whole numbers above 255 shares of 65535."""
    if (colors := _columns(mesh.vertices)) is not None:
        return _as_bytes(colors)
    if (colors := _columns(mesh.of_face)) is None:
        return None
    count = len(next(iter(mesh.vertices.values())))
    corners = mesh.triangles.ravel()
    sums = [np.bincount(corners, np.repeat(column, 3), count) for column in colors.T]
    n_faces = np.bincount(corners, minlength=count).clip(1)
    return _as_bytes(np.stack(sums, axis=1) / n_faces[:, None], whole=np.issubdtype(colors.dtype, np.integer))


def _columns(properties: Mapping[str, NDArray]) -> NDArray | None:
    by_name = {name.lower(): column for name, column in properties.items()}
    for names in _NAMES:
        if all(name in by_name for name in names):
            return np.stack([by_name[name] for name in names], axis=1)
    return None


def _as_bytes(colors: NDArray, whole: bool | None = None) -> Uint8Array:
    if colors.dtype == np.uint8:
        return np.ascontiguousarray(colors, dtype=np.uint8)
    values: Float64Array = np.nan_to_num(colors.astype(np.float64))
    is_whole = np.issubdtype(colors.dtype, np.integer) if whole is None else whole
    largest = values.max(initial=0)
    scale = 255 / 65535 if largest > 255 else 1.0 if is_whole or largest > 1 else 255.0
    return np.rint(values * scale).clip(0, 255).astype(np.uint8)
