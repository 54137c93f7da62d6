"""A strict reader of binary glTF 2.0: whatever the specification demands of the parts we write is checked."""

from __future__ import annotations

import json
import struct

import numpy as np

TYPES = {5126: np.dtype("<f4"), 5123: np.dtype("<u2"), 5125: np.dtype("<u4")}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


def read_glb(path):
    """(document, arrays), the latter one for each accessor; fails on anything that is not as specified."""
    document, binary = chunks(path)
    assert document["asset"]["version"] == "2.0"
    arrays = [accessor(document, binary, entry) for entry in document.get("accessors", [])]
    check_views(document, binary)
    check_nodes(document)
    for mesh in document.get("meshes", []):
        for primitive in mesh["primitives"]:
            check_primitive(document, arrays, primitive)
    return document, arrays


def chunks(path):
    data = path.read_bytes()
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    assert length % 4 == 0
    found, offset = [], 12
    while offset < length:
        size, kind = struct.unpack_from("<II", data, offset)
        assert size % 4 == 0
        found.append((kind, data[offset + 8 : offset + 8 + size]))
        offset += 8 + size
    assert offset == length
    assert [kind for kind, _ in found] in ([0x4E4F534A], [0x4E4F534A, 0x004E4942])
    return json.loads(found[0][1]), found[1][1] if len(found) > 1 else b""


def accessor(document, binary, entry):
    view = document["bufferViews"][entry["bufferView"]]
    kind, width = TYPES[entry["componentType"]], WIDTHS[entry["type"]]
    offset, size = entry.get("byteOffset", 0), kind.itemsize * width
    stride = view.get("byteStride", size)
    assert entry["count"] >= 1
    assert offset % kind.itemsize == view.get("byteOffset", 0) % kind.itemsize == stride % kind.itemsize == 0
    assert offset + stride * (entry["count"] - 1) + size <= view["byteLength"]
    start = view.get("byteOffset", 0) + offset
    rows = [np.frombuffer(binary, kind, width, start + stride * i) for i in range(entry["count"])]
    array = np.stack(rows)
    if "min" in entry:
        assert (array.min(axis=0) == entry["min"]).all()
        assert (array.max(axis=0) == entry["max"]).all()
    return array


def check_views(document, binary):
    end = 0
    for number, view in enumerate(document.get("bufferViews", [])):
        assert view.get("byteOffset", 0) >= end
        end = view["byteOffset"] + view["byteLength"]
        users = [a for a in document["accessors"] if a["bufferView"] == number]
        if view["target"] == 34962:
            assert view.get("byteOffset", 0) % 4 == 0
            assert len(users) == 1 or (view["byteStride"] % 4 == 0 and 4 <= view["byteStride"] <= 252)
        else:
            assert "byteStride" not in view
    if binary:
        (buffer,) = document["buffers"]
        assert end == buffer["byteLength"]
        assert 0 <= len(binary) - buffer["byteLength"] <= 3


def check_nodes(document):
    nodes = document["nodes"]
    children = [child for node in nodes for child in node.get("children", [])]
    roots = document["scenes"][document["scene"]]["nodes"]
    assert sorted(children + roots) == list(range(len(nodes)))  # a tree: each has one parent or is a root
    for node in nodes:
        assert "mesh" not in node or node["mesh"] < len(document["meshes"])
        assert np.isclose(np.linalg.norm(node.get("rotation", [0, 0, 0, 1])), 1, atol=1e-5)


def check_primitive(document, arrays, primitive):
    entries = {name: document["accessors"][number] for name, number in primitive["attributes"].items()}
    count = entries["POSITION"]["count"]
    assert {entry["count"] for entry in entries.values()} == {count}
    assert {"min", "max"} <= set(entries["POSITION"])
    assert entries["COLOR_0"]["normalized"]
    normals = arrays[primitive["attributes"]["NORMAL"]]
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-4)
    indices = arrays[primitive["indices"]]
    assert document["accessors"][primitive["indices"]]["type"] == "SCALAR"
    assert len(indices) % 3 == 0
    assert indices.max() < count
    assert primitive["material"] < len(document["materials"])
