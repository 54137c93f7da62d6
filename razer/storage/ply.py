"""Binary PLY of labelled meshes, written and read."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from razer.arrays import Int32Array
from razer.errors import BadInput
from razer.files import read_bytes
from razer.mesh.labelled_mesh import LabelledMesh

VERTEX = np.dtype(
    [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("red", "u1"), ("green", "u1"), ("blue", "u1"), ("instance", "<i4")]
)
FACE = np.dtype([("n", "u1"), ("a", "<i4"), ("b", "<i4"), ("c", "<i4")])
PLY_TYPES = {"<f4": "float", "|u1": "uchar", "<i4": "int"}


def write_mesh_ply(path: Path, mesh: LabelledMesh) -> None:
    """Binary PLY with the instance of each vertex as an integer property."""
    vertices = vertex_rows(mesh, VERTEX)
    vertices["instance"] = mesh.instances
    write_ply(path, vertices, mesh.triangles)


def write_ply(path: Path, vertices: NDArray, triangles: Int32Array) -> None:
    """Binary PLY of vertices (V,) with named fields of the types in PLY_TYPES, and triangles (T, 3)."""
    faces = np.empty(len(triangles), FACE)
    faces["n"] = 3
    faces["a"], faces["b"], faces["c"] = triangles.T
    fields = vertices.dtype
    properties = [f"property {PLY_TYPES[fields[name].str]} {name}" for name in fields.names or ()]
    header = [
        "ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}", *properties,
        f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", "",
    ]  # fmt: skip
    with path.open("wb") as file:
        file.write("\n".join(header).encode())
        for rows in (vertices, faces):
            file.write(np.ascontiguousarray(rows).data)  # tofile would not say why a disk takes no more


def vertex_rows(mesh: LabelledMesh, fields: np.dtype) -> NDArray:
    """Rows (V,) with the given fields, of which place and colour are filled."""
    vertices = np.zeros(len(mesh.vertices), fields)
    for i, name in enumerate("xyz"):
        vertices[name] = mesh.vertices[:, i]
    for i, name in enumerate(("red", "green", "blue")):
        vertices[name] = mesh.colors[:, i]
    return vertices


def read_mesh_ply(path: Path) -> LabelledMesh:
    """Read a mesh that `write_mesh_ply` wrote; raises BadInput if it is another kind of file."""
    if not path.is_file():
        raise BadInput(f"{path} does not exist: give the mesh.ply of a run")
    data = read_bytes(path)
    start = data.find(b"end_header\n") + len(b"end_header\n")
    header = data[:start].decode("ascii", "replace")
    counts = [int(n) for n in re.findall(r"^element (?:vertex|face) (\d+)$", header, re.MULTILINE)]
    names = re.findall(r"^property (?!list)\w+ (\w+)$", header, re.MULTILINE)
    if len(counts) != 2 or tuple(names) != VERTEX.names:
        raise BadInput(f"{path} is no mesh of a run: expected vertices with {', '.join(VERTEX.names or ())}")
    if max(counts) > len(data) or len(data) - start != counts[0] * VERTEX.itemsize + counts[1] * FACE.itemsize:
        raise BadInput(f"{path} is cut short: run again to write it anew")
    vertices = np.frombuffer(data, VERTEX, counts[0], start)
    faces = np.frombuffer(data, FACE, counts[1], start + vertices.nbytes)
    points, triangles = (
        np.stack([rows[n] for n in names], axis=1) for rows, names in ((vertices, "xyz"), (faces, "abc"))
    )
    if not np.isfinite(points).all() or (triangles < 0).any() or (triangles >= len(points)).any():
        raise BadInput(f"{path} is damaged: a vertex is nowhere, or a face has corners that are no vertices; run again")
    return LabelledMesh(
        points,
        np.stack([vertices[n] for n in ("red", "green", "blue")], axis=1),
        vertices["instance"].astype(np.int32),
        triangles,
    )
