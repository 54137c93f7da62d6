"""The GLB container against the glTF 2.0 specification and another reader."""

from __future__ import annotations

import json
import struct

import numpy as np
import open3d as o3d
import pytest

from app.glb import write_glb
from app.palette import instance_colors, tinted
from razer.normals import vertex_normals
from razer.surface import LabelledMesh


def tetrahedron():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 2]], np.float32)
    triangles = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)
    colors = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [128, 128, 128]], np.uint8)
    return LabelledMesh(vertices, colors, np.array([0, 0, 7, 7], np.int32), triangles)


def parse(path):
    data = path.read_bytes()
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    chunks, offset = {}, 12
    while offset < length:
        size, kind = struct.unpack_from("<II", data, offset)
        assert size % 4 == 0
        chunks[kind] = data[offset + 8 : offset + 8 + size]
        offset += 8 + size
    return json.loads(chunks[0x4E4F534A]), chunks.get(0x004E4942, b"")


def accessor(document, binary, index):
    entry = document["accessors"][index]
    view = document["bufferViews"][entry["bufferView"]]
    kinds = {5126: "<f4", 5123: "<u2", 5125: "<u4"}
    width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[entry["type"]]
    count = entry["count"] * width
    return np.frombuffer(binary, kinds[entry["componentType"]], count, view["byteOffset"]).reshape(-1, width)


def test_what_is_written_is_the_mesh(tmp_path):
    mesh = tetrahedron()
    write_glb(tmp_path / "mesh.glb", mesh)
    document, binary = parse(tmp_path / "mesh.glb")
    primitive = document["meshes"][0]["primitives"][0]
    np.testing.assert_array_equal(accessor(document, binary, primitive["attributes"]["POSITION"]), mesh.vertices)
    indices = accessor(document, binary, primitive["indices"])
    np.testing.assert_array_equal(indices.reshape(-1, 3), mesh.triangles)
    bounds = document["accessors"][primitive["attributes"]["POSITION"]]
    assert (bounds["min"], bounds["max"]) == ([0, 0, 0], [1, 1, 2])
    colors = accessor(document, binary, primitive["attributes"]["COLOR_0"]) / 65535
    # Nobody's vertices keep their colour; glTF wants linear light, where sRGB 128 is 0.2159.
    np.testing.assert_allclose(colors[:2], [[1, 0, 0, 1], [0, 1, 0, 1]])
    tint = tinted(mesh.colors, mesh.instances)[3] / 255
    np.testing.assert_allclose(colors[3, :3], ((tint + 0.055) / 1.055) ** 2.4, atol=2e-5)
    assert document["buffers"][0]["byteLength"] <= len(binary)


def test_another_reader_agrees(tmp_path):
    mesh = tetrahedron()
    write_glb(tmp_path / "mesh.glb", mesh)
    read = o3d.io.read_triangle_mesh(str(tmp_path / "mesh.glb"))
    corners = np.asarray(read.vertices)[np.asarray(read.triangles)]  # that reader renumbers vertices
    np.testing.assert_allclose(corners, mesh.vertices[mesh.triangles], atol=1e-6)


def test_an_empty_map_is_a_scene_without_a_mesh(tmp_path):
    empty = np.zeros((0, 3), np.int32)
    mesh = LabelledMesh(empty.astype(np.float32), empty.astype(np.uint8), empty[:, 0], empty)
    write_glb(tmp_path / "mesh.glb", mesh)
    document, binary = parse(tmp_path / "mesh.glb")
    assert "meshes" not in document
    assert "buffers" not in document
    assert binary == b""


def test_normals_point_out_of_a_closed_mesh_with_outward_faces():
    mesh = tetrahedron()
    normals = vertex_normals(mesh)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1)
    outward = mesh.vertices - mesh.vertices.mean(axis=0)
    assert ((normals * outward).sum(axis=1) > 0).all()


@pytest.mark.parametrize("up", [(0, 0, 1), (0, -1, 0), (0, 1, 0), (1, 2, -3), (0, -2, 1e-12), (0, 0, 0)])
def test_up_is_shown_upwards(tmp_path, up):
    write_glb(tmp_path / "mesh.glb", tetrahedron(), np.array(up, float))
    x, y, z, w = parse(tmp_path / "mesh.glb")[0]["nodes"][0]["rotation"]
    assert np.linalg.norm([x, y, z, w]) == pytest.approx(1)
    direction = np.array(up, float)
    length = np.linalg.norm(direction)
    axis = np.array([x, y, z])
    rotated = direction + 2 * np.cross(axis, np.cross(axis, direction) + w * direction)
    np.testing.assert_allclose(rotated, [0, length, 0], atol=1e-6)


def test_colours_tell_neighbouring_ids_apart_and_leave_nobody_grey():
    colors = instance_colors(np.arange(41)).astype(int)
    assert colors[0].tolist() == [128, 128, 128]
    assert len({tuple(color) for color in colors}) == 41
    for near in (1, 2, 3):
        assert np.abs(colors[1 + near :] - colors[1:-near]).sum(axis=1).min() > 60
