"""Export of the labelled mesh as binary glTF 2.0, which any 3D viewer opens: a node for each instance."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from razer.arrays import BoolArray, Float64Array, IntArray, Uint8Array, Uint16Array
from razer.mesh.labelled_mesh import LabelledMesh
from razer.models.stuff_names import is_stuff_name
from razer.panoptic_map import PanopticMap
from razer.semantics.normals import vertex_normals

_FLOAT, _UINT16, _UINT32 = 5126, 5123, 5125
_VERTICES, _INDICES = 34962, 34963
_CHUNK_JSON, _CHUNK_BIN = 0x4E4F534A, 0x004E4942
# The light of the place is in the colours already; one looks into rooms through the backs of their walls.
_UNLIT = "KHR_materials_unlit"
_MATERIAL = {
    "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 1.0},
    "doubleSided": False,
    "extensions": {_UNLIT: {}},
}
_QUIET_COLOR, _QUIET_LIGHT = 0.3, 0.35  # shares of its colour and of a light grey that a quiet surface has
_LIGHT = 214
# Of each buffer view: component type, type, and bytes of an element.
_ATTRIBUTES = {"POSITION": (_FLOAT, "VEC3", 12), "NORMAL": (_FLOAT, "VEC3", 12), "COLOR_0": (_UINT16, "VEC4", 8)}


@dataclass(frozen=True)
class NodeFacts:
    """What a node says of its instance: its class and its score, None where there is none."""

    class_name: str | None = None
    score: float | None = None

    def name(self, instance: int) -> str:
        """Of the node: the class, where there is one, and the id."""
        return f"{self.class_name or 'instance'} {instance}"

    def extras(self, instance: int) -> dict[str, Any]:
        """Of the node, for programs."""
        score = None if self.score is None else round(self.score, 4)
        return {"id": instance, "class": self.class_name, "score": score}


def write_glb(
    path: Path,
    mesh: LabelledMesh,
    up: Float64Array | None = None,
    facts: Mapping[int, NodeFacts] = MappingProxyType({}),
) -> None:
    """Write a mesh in its own colours as a node for each instance and one for the rest; what has no name is paler,
    where things have names.

    Args:
        path: the file.
        mesh: the labelled surface.
        up: (3,) the world direction that viewers show upwards (glTF: +y); None = +y already.
        facts: of the instances, by id.
    """
    parts = list(_parts(mesh))
    columns = _columns(mesh, parts, _is_quiet(mesh, facts))
    n_bytes = sum(column.nbytes for column in columns)
    text = json.dumps(_document(parts, columns, up, facts)).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), _CHUNK_JSON) + text
    if n_bytes:
        chunks += struct.pack("<II", n_bytes, _CHUNK_BIN)
    with path.open("wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks) + n_bytes) + chunks)
        for column in columns:  # one after the other: all of them joined would take as much memory again
            file.write(column.tobytes())


def write_map_glb(path: Path, panoptic: PanopticMap) -> None:
    """Write a map's mesh, upright, with what is known of its instances."""
    facts = {o.id: NodeFacts(o.class_name, o.score) for o in panoptic.objects}
    write_glb(path, panoptic.mesh, panoptic.up, facts)


Part = tuple[int, IntArray, NDArray[np.uint32]]


def _parts(mesh: LabelledMesh) -> Iterator[Part]:
    """Instance, its vertices, and its triangles (T, 3) among these. A triangle belongs to two of its vertices, or else
    to the first; what it has of other instances is copied."""
    if len(mesh.triangles) == 0:
        return
    a, b, c = mesh.instances[mesh.triangles].T
    owner = np.where(b == c, b, a)
    order = np.argsort(owner, kind="stable")
    instances, first = np.unique(owner[order], return_index=True)
    for instance, rows in zip(instances.tolist(), np.split(order, first[1:]), strict=True):
        vertices, corners = np.unique(mesh.triangles[rows], return_inverse=True)
        yield instance, vertices, corners.reshape(-1, 3).astype(np.uint32)


def _is_quiet(mesh: LabelledMesh, facts: Mapping[int, NodeFacts]) -> BoolArray:
    """Vertices (V,) without a name, where things have names."""
    named = [number for number, one in facts.items() if one.class_name]
    if all(is_stuff_name(facts[number].class_name or "") for number in named):
        return np.zeros(len(mesh.vertices), np.bool_)
    return ~np.isin(mesh.instances, named)


def quiet(colors: Uint8Array) -> Uint8Array:
    """Colours (N, 3), paler and greyer."""
    grey = colors.mean(axis=1, keepdims=True)
    mixed = (1 - _QUIET_LIGHT) * (_QUIET_COLOR * colors + (1 - _QUIET_COLOR) * grey) + _QUIET_LIGHT * _LIGHT
    return np.round(mixed).astype(np.uint8)


def _columns(mesh: LabelledMesh, parts: list[Part], is_quiet: BoolArray) -> list[NDArray]:
    """Positions, normals, colours and indices of all parts; none of an empty mesh, as glTF knows no empty arrays."""
    if not parts:
        return []
    vertices = np.concatenate([rows for _, rows, _ in parts])
    columns = (mesh.vertices.astype("<f4"), vertex_normals(mesh).astype("<f4"))
    colors = _linear_rgba16(np.where(is_quiet[:, None], quiet(mesh.colors), mesh.colors))
    indices = np.concatenate([corners.reshape(-1) for *_, corners in parts]).astype("<u4")
    return [*(column[vertices] for column in (*columns, colors)), indices]


def _document(
    parts: list[Part], columns: list[NDArray], up: Float64Array | None, facts: Mapping[int, NodeFacts]
) -> dict[str, Any]:
    root: dict[str, Any] = {"name": "map", "rotation": _quaternion_to_y(up)}
    document: dict[str, Any] = {"asset": {"version": "2.0", "generator": "razer"}, "scene": 0}
    document |= {"scenes": [{"nodes": [0]}], "nodes": [root]}
    if not parts:
        return document
    root["children"] = list(range(1, len(parts) + 1))
    for number, (instance, *_) in enumerate(parts):
        node: dict[str, Any] = {"name": "rest", "mesh": number}
        if instance:
            own = facts.get(instance, NodeFacts())
            node |= {"name": own.name(instance), "extras": own.extras(instance)}
        document["nodes"].append(node)
    accessors = list(_accessors(parts, columns[0]))
    return document | {
        "meshes": [{"primitives": [_primitive(number)]} for number in range(len(parts))],
        "materials": [_MATERIAL],
        "extensionsUsed": [_UNLIT],
        "buffers": [{"byteLength": sum(column.nbytes for column in columns)}],
        "bufferViews": _views(columns),
        "accessors": accessors,
    }


def _primitive(number: int) -> dict[str, Any]:
    first = number * (len(_ATTRIBUTES) + 1)
    attributes = {name: first + i for i, name in enumerate(_ATTRIBUTES)}
    return {"attributes": attributes, "indices": first + len(_ATTRIBUTES), "material": 0}


def _views(columns: list[NDArray]) -> list[dict[str, Any]]:
    views: list[dict[str, Any]] = []
    offset = 0
    strides = [stride for *_, stride in _ATTRIBUTES.values()]
    for column, stride in zip(columns, [*strides, None], strict=True):
        view = {"buffer": 0, "byteOffset": offset, "byteLength": column.nbytes}
        views.append(view | ({"target": _INDICES} if stride is None else {"target": _VERTICES, "byteStride": stride}))
        offset += column.nbytes
    return views


def _accessors(parts: list[Part], positions: NDArray) -> Iterator[dict[str, Any]]:
    """Of each part its attributes, in the order of _ATTRIBUTES, and its indices."""
    vertex = index = 0
    for _, vertices, corners in parts:
        own = positions[vertex : vertex + len(vertices)]
        for view, (name, (component, kind, stride)) in enumerate(_ATTRIBUTES.items()):
            accessor: dict[str, Any] = {"bufferView": view, "byteOffset": vertex * stride, "componentType": component}
            accessor |= {"count": len(vertices), "type": kind}
            if name == "POSITION":
                accessor |= {"min": own.min(0).tolist(), "max": own.max(0).tolist()}
            if name == "COLOR_0":
                accessor["normalized"] = True
            yield accessor
        accessor = {"bufferView": len(_ATTRIBUTES), "byteOffset": index * 4, "componentType": _UINT32}
        yield accessor | {"count": corners.size, "type": "SCALAR"}
        vertex, index = vertex + len(vertices), index + corners.size


def _linear_rgba16(srgb: Uint8Array) -> Uint16Array:
    """glTF vertex colours are linear light: undo the sRGB curve, in 16 bit so that dark tones do not band."""
    value = np.arange(256) / 255
    curve = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    table = np.round(65535 * curve).astype("<u2")
    return np.column_stack([table[srgb], np.full(len(srgb), 65535, "<u2")])


def _quaternion_to_y(up: Float64Array | None) -> list[float]:
    """The shortest rotation (x, y, z, w) that takes `up` to +y."""
    if up is None or not np.linalg.norm(up) > 0:
        return [0.0, 0.0, 0.0, 1.0]
    x, y, z = up / np.linalg.norm(up)
    if y < -1 + 1e-9:
        return [1.0, 0.0, 0.0, 0.0]
    quaternion = np.array([-z, 0.0, x, 1.0 + y])
    return (quaternion / np.linalg.norm(quaternion)).tolist()
