"""Writer of labelled meshes as binary PLY."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from data_tools.recordings.local_origin import HERE, local_origin
from razer.arrays import FloatArray, Int32Array, IntArray, Uint8Array

_TYPES = {"<f4": "float", "<f8": "double", "<i4": "int", "<u4": "uint", "<u2": "ushort", "|u1": "uchar"}


def write_ply(
    path: Path,
    points: FloatArray,
    properties: Mapping[str, NDArray],
    triangles: Int32Array,
    of_face: Mapping[str, NDArray] | None = None,
) -> None:
    """Write a mesh as little-endian binary PLY.

    Args:
        path: the file.
        points: (V, 3) metres, written as float32, or as float64 where they are that and lie far from zero.
        properties: further columns (V,) by name.
        triangles: (T, 3) numbers of vertices.
        of_face: columns (T,) by name; None = none.
    """
    is_far = points.dtype == np.float64 and local_origin(points) != HERE
    columns = {name: points[:, i].astype("<f8" if is_far else "<f4") for i, name in enumerate("xyz")} | dict(properties)
    corners = np.empty(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    corners["count"], corners["corners"] = 3, triangles
    faces = {"corners": corners} | dict(of_face or {})
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}", *_lines(columns)]
    header += [f"element face {len(triangles)}", "property list uchar int vertex_indices", *_lines(of_face or {})]
    data = "\n".join([*header, "end_header", ""]).encode() + _table(columns, len(points))
    path.write_bytes(data + _table(faces, len(triangles)))


def label_colors(labels: IntArray) -> dict[str, Uint8Array]:
    """A colour for each label as the columns red, green and blue, black for 0."""
    factors = {"red": 2654435761, "green": 2246822519, "blue": 3266489917}
    bits = labels.astype(np.uint32)
    return {name: (bits * np.uint32(factor) >> np.uint32(24)).astype(np.uint8) for name, factor in factors.items()}


def _lines(columns: Mapping[str, NDArray]) -> list[str]:
    return [f"property {_TYPES[column.dtype.str]} {name}" for name, column in columns.items()]


def _table(columns: Mapping[str, NDArray], count: int) -> bytes:
    table = np.empty(count, [(name, column.dtype) for name, column in columns.items()])
    for name, column in columns.items():
        table[name] = column
    return table.tobytes()
