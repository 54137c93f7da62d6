"""The GLB container against the glTF 2.0 specification and another reader."""

from __future__ import annotations

import numpy as np
import open3d as o3d
import pytest

from app.render.glb import NodeFacts, quiet, write_glb
from app.render.palette import instance_colors
from razer.mesh.labelled_mesh import LabelledMesh
from razer.semantics.normals import vertex_normals
from tests.support.gltf import read_glb


def tetrahedron():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 2]], np.float32)
    triangles = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)
    colors = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [128, 128, 128]], np.uint8)
    return LabelledMesh(vertices, colors, np.array([0, 0, 7, 7], np.int32), triangles)


def by_node(path):
    """Node name to (positions, indices, colours)."""
    document, arrays = read_glb(path)
    found = {}
    for node in document["nodes"]:
        if "mesh" in node:
            (primitive,) = document["meshes"][node["mesh"]]["primitives"]
            at = primitive["attributes"]
            found[node["name"]] = (arrays[at["POSITION"]], arrays[primitive["indices"]][:, 0], arrays[at["COLOR_0"]])
    return found


def test_each_instance_is_a_node_and_together_they_are_the_mesh(tmp_path):
    mesh = tetrahedron()
    write_glb(tmp_path / "mesh.glb", mesh, facts={7: NodeFacts("lamp", 0.9)})
    nodes = by_node(tmp_path / "mesh.glb")
    assert set(nodes) == {"rest", "lamp 7"}
    # Two triangles have two corners of the instance, two have one.
    triangles = {name: positions[indices].reshape(-1, 3, 3) for name, (positions, indices, _) in nodes.items()}
    np.testing.assert_array_equal(triangles["rest"], mesh.vertices[mesh.triangles[[0, 1]]])
    np.testing.assert_array_equal(triangles["lamp 7"], mesh.vertices[mesh.triangles[[2, 3]]])


def linear(srgb):
    """Linear light of sRGB values from 0 to 255: 128 is 0.2159."""
    share = np.asarray(srgb) / 255
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def test_colours_are_the_mesh_s_own_in_linear_light(tmp_path):
    mesh = tetrahedron()
    write_glb(tmp_path / "mesh.glb", mesh)
    colors = {name: column / 65535 for name, (*_, column) in by_node(tmp_path / "mesh.glb").items()}
    np.testing.assert_allclose(colors["rest"][:2], [[1, 0, 0, 1], [0, 1, 0, 1]])
    np.testing.assert_allclose(colors["instance 7"][-1, :3], linear(128), atol=2e-5)


def test_what_has_no_name_is_quiet_where_things_have_one(tmp_path):
    mesh = tetrahedron()
    write_glb(tmp_path / "mesh.glb", mesh, facts={7: NodeFacts("lamp", 0.9)})
    colors = {name: column / 65535 for name, (*_, column) in by_node(tmp_path / "mesh.glb").items()}
    np.testing.assert_allclose(colors["lamp 7"][-1, :3], linear(128), atol=2e-5)
    np.testing.assert_allclose(colors["rest"][0, :3], linear(quiet(mesh.colors[:1])[0]), atol=2e-5)
    write_glb(tmp_path / "mesh.glb", mesh, facts={7: NodeFacts("wall", 0.9)})  # of a map without named things
    colors = {name: column / 65535 for name, (*_, column) in by_node(tmp_path / "mesh.glb").items()}
    np.testing.assert_allclose(colors["rest"][0], [1, 0, 0, 1])


def test_quiet_colours_differ_less_and_are_lighter():
    colors = np.array([[255, 0, 0], [0, 0, 90], [60, 60, 60]], np.uint8)
    pale = quiet(colors).astype(int)
    assert (np.ptp(pale, axis=1) < 0.4 * np.ptp(colors, axis=1).clip(1)).all()
    assert (pale.mean(axis=1) > colors.mean(axis=1)).all()


def test_nodes_say_class_score_and_id_and_only_front_faces_are_drawn(tmp_path):
    write_glb(tmp_path / "mesh.glb", tetrahedron(), facts={7: NodeFacts("lamp", 0.87654)})
    document, _ = read_glb(tmp_path / "mesh.glb")
    extras = {node["name"]: node.get("extras") for node in document["nodes"][1:]}
    assert extras == {"rest": None, "lamp 7": {"id": 7, "class": "lamp", "score": 0.8765}}
    (material,) = document["materials"]
    assert material["doubleSided"] is False
    assert set(material["extensions"]) == set(document["extensionsUsed"]) == {"KHR_materials_unlit"}


def test_names_tell_class_and_instance():
    assert [NodeFacts("chair").name(3), NodeFacts().name(4)] == ["chair 3", "instance 4"]


def test_a_mesh_of_many_instances_keeps_every_triangle(tmp_path):
    rng = np.random.default_rng(0)
    vertices = rng.normal(size=(200, 3)).astype(np.float32)
    triangles = rng.permuted(np.tile(np.arange(200), (300, 1)), axis=1)[:, :3].astype(np.int32)
    mesh = LabelledMesh(vertices, rng.integers(0, 256, (200, 3)).astype(np.uint8), rng.integers(0, 9, 200), triangles)
    write_glb(tmp_path / "mesh.glb", mesh)
    nodes = by_node(tmp_path / "mesh.glb")
    written = np.concatenate([positions[indices].reshape(-1, 9) for positions, indices, _ in nodes.values()])
    expected = vertices[triangles].reshape(-1, 9)
    np.testing.assert_array_equal(written[np.lexsort(written.T)], expected[np.lexsort(expected.T)])


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
    document, arrays = read_glb(tmp_path / "mesh.glb")
    assert "meshes" not in document
    assert "buffers" not in document
    assert arrays == []


def test_normals_point_out_of_a_closed_mesh_with_outward_faces():
    mesh = tetrahedron()
    normals = vertex_normals(mesh)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1)
    outward = mesh.vertices - mesh.vertices.mean(axis=0)
    assert ((normals * outward).sum(axis=1) > 0).all()


@pytest.mark.parametrize("up", [(0, 0, 1), (0, -1, 0), (0, 1, 0), (1, 2, -3), (0, -2, 1e-12), (0, 0, 0)])
def test_up_is_shown_upwards(tmp_path, up):
    write_glb(tmp_path / "mesh.glb", tetrahedron(), np.array(up, float))
    x, y, z, w = read_glb(tmp_path / "mesh.glb")[0]["nodes"][0]["rotation"]
    assert np.linalg.norm([x, y, z, w]) == pytest.approx(1)
    direction = np.array(up, float)
    length = np.linalg.norm(direction)
    axis = np.array([x, y, z])
    rotated = direction + 2 * np.cross(axis, np.cross(axis, direction) + w * direction)
    np.testing.assert_allclose(rotated, [0, length, 0], atol=1e-6)


def test_colours_tell_neighbouring_ids_apart_and_leave_nobody_grey():
    colors = instance_colors(np.arange(41)).astype(int)
    assert np.ptp(colors[0]) < 10
    assert len({tuple(color) for color in colors}) == 41
    for near in (1, 2, 3):
        assert np.abs(colors[1 + near :] - colors[1:-near]).sum(axis=1).min() > 60
