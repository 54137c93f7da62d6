"""The labelled mesh as binary glTF 2.0, which any 3D viewer opens; instances are tinted."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.palette import tinted
from razer.surface import LabelledMesh

_FLOAT, _UINT16, _UINT32 = 5126, 5123, 5125
_VERTICES, _INDICES = 34962, 34963
_CHUNK_JSON, _CHUNK_BIN = 0x4E4F534A, 0x004E4942


def write_glb(path: Path, mesh: LabelledMesh, up: NDArray[np.float64] | None = None) -> None:
    """Write `mesh` to `path`; `up` (3,) is the world direction that viewers show upwards (glTF: +y)."""
    arrays = (
        [
            (mesh.vertices.astype("<f4"), _FLOAT, "VEC3", _VERTICES),
            (vertex_normals(mesh).astype("<f4"), _FLOAT, "VEC3", _VERTICES),
            (_linear_rgba16(tinted(mesh.colors, mesh.instances)), _UINT16, "VEC4", _VERTICES),
            (mesh.triangles.astype("<u4").reshape(-1), _UINT32, "SCALAR", _INDICES),
        ]
        if len(mesh.triangles)
        else []  # glTF knows no empty arrays: an empty map is a scene without a mesh
    )
    binary = b"".join(array.tobytes() for array, *_ in arrays)
    text = json.dumps(_document(arrays, len(binary), up)).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), _CHUNK_JSON) + text
    if binary:
        chunks += struct.pack("<II", len(binary), _CHUNK_BIN) + binary
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def _document(
    arrays: list[tuple[NDArray, int, str, int]], n_bytes: int, up: NDArray[np.float64] | None
) -> dict[str, Any]:
    node: dict[str, Any] = {"name": "map", "rotation": _quaternion_to_y(up)}
    document: dict[str, Any] = {"asset": {"version": "2.0", "generator": "razer"}, "scene": 0}
    document |= {"scenes": [{"nodes": [0]}], "nodes": [node]}
    if not arrays:
        return document
    node["mesh"] = 0
    views: list[dict[str, Any]] = []
    accessors: list[dict[str, Any]] = []
    offset = 0
    for array, component, kind, target in arrays:
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": array.nbytes, "target": target})
        accessor: dict[str, Any] = {
            "bufferView": len(accessors),
            "componentType": component,
            "count": len(array),
            "type": kind,
        }
        if kind == "VEC4":
            accessor["normalized"] = True
        accessors.append(accessor)
        offset += array.nbytes
    positions = arrays[0][0]
    accessors[0] |= {"min": positions.min(0).tolist(), "max": positions.max(0).tolist()}
    attributes = {"POSITION": 0, "NORMAL": 1, "COLOR_0": 2}
    primitive = {"attributes": attributes, "indices": 3, "material": 0}
    matte = {"pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 1.0}, "doubleSided": True}
    return document | {
        "meshes": [{"primitives": [primitive]}],
        "materials": [matte],
        "buffers": [{"byteLength": n_bytes}],
        "bufferViews": views,
        "accessors": accessors,
    }


def vertex_normals(mesh: LabelledMesh) -> NDArray[np.float64]:
    """Unit normals (V, 3): adjacent triangles' normals weighted by area; (0, 1, 0) where there are none."""
    a, b, c = (mesh.vertices[mesh.triangles[:, corner]].astype(np.float64) for corner in range(3))
    face_normals = np.cross(b - a, c - a)
    corners = mesh.triangles.reshape(-1)
    sums = np.stack(
        [np.bincount(corners, np.repeat(face_normals[:, axis], 3), len(mesh.vertices)) for axis in range(3)],
        axis=1,
    )
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.where(lengths > 0, sums / np.where(lengths > 0, lengths, 1.0), (0.0, 1.0, 0.0))


def _linear_rgba16(srgb: NDArray[np.uint8]) -> NDArray[np.uint16]:
    """glTF vertex colours are linear light: undo the sRGB curve, in 16 bit so that dark tones do not band."""
    value = np.arange(256) / 255
    curve = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    table = np.round(65535 * curve).astype("<u2")
    return np.column_stack([table[srgb], np.full(len(srgb), 65535, "<u2")])


def _quaternion_to_y(up: NDArray[np.float64] | None) -> list[float]:
    """The shortest rotation (x, y, z, w) that takes `up` to +y."""
    if up is None or not np.linalg.norm(up) > 0:
        return [0.0, 0.0, 0.0, 1.0]
    x, y, z = up / np.linalg.norm(up)
    if y < -1 + 1e-9:
        return [1.0, 0.0, 0.0, 0.0]
    quaternion = np.array([-z, 0.0, x, 1.0 + y])
    return (quaternion / np.linalg.norm(quaternion)).tolist()
