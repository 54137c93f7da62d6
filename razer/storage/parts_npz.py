"""parts.npz: which vertices of the mesh are of which part, written and read."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from razer.arrays import Int32Array
from razer.files import read_npz

FORMAT = 1


def write_parts_npz(path: Path, vertex_parts: Int32Array) -> None:
    """The part (V,) of each vertex, 0 = none, as the rows (n,) of those that have one and their parts (n,)."""
    vertices = np.flatnonzero(vertex_parts)
    np.savez_compressed(path, format=FORMAT, vertices=vertices.astype(np.int32), parts=vertex_parts[vertices])


def read_parts_npz(path: Path, n_vertices: int) -> Int32Array:
    """The part (V,) of each of so many vertices; raises one of MALFORMED for a file that is none of this
    mesh."""
    arrays = read_npz(path, ["vertices", "parts", "format"])
    vertices, parts, version = arrays["vertices"], arrays["parts"], int(arrays["format"])
    if version != FORMAT:
        raise ValueError(f"format {version}, this version reads {FORMAT}")
    if vertices.shape != parts.shape or (len(vertices) and not 0 <= vertices.min() <= vertices.max() < n_vertices):
        raise ValueError("its parts are of another mesh")
    labels = np.zeros(n_vertices, np.int32)
    labels[vertices] = parts
    return labels
