"""PLY files of every flavour hold the same mesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import open3d as o3d
import pytest

from data_tools.truth.ply import Ply, read_ply
from razer.errors import BadInput

VERTICES = [(0.5, -1.0, 2.0, 7, 1000), (1.5, 0.25, -3.0, 200, 70000), (0.0, 0.0, 1.0, 0, 5), (4.0, 1.0, 1.0, 9, 6)]
FACES = [([0, 1, 2], 11), ([2, 1, 3], 12)]
QUADS = [([0, 1, 2, 3], 11), ([3, 2, 1, 0], 12)]
MIXED = [([0, 1, 2], 11), ([0, 1, 2, 3], 12), ([0, 1], 13)]
FLAVOURS = ("ascii", "binary_little_endian", "binary_big_endian")


def header(flavour: str, vertices: int, faces: int) -> bytes:
    lines = ["ply", f"format {flavour} 1.0", "comment a b", f"element vertex {vertices}"]
    lines += ["property float x", "property double y", "property float32 z", "property uchar red", "property int label"]
    lines += [f"element face {faces}", "property uchar mark", "property list uchar int vertex_indices"]
    return "\n".join([*lines, "property ushort object_id", "end_header", ""]).encode()


def body(flavour: str, faces: list[tuple[list[int], int]]) -> bytes:
    if flavour == "ascii":
        lines = [" ".join(map(str, vertex)) for vertex in VERTICES]
        lines += [" ".join(map(str, (1, len(corners), *corners, number))) for corners, number in faces]
        return ("\n".join(lines) + "\n").encode()
    order = "<" if "little" in flavour else ">"
    kinds = [order + kind for kind in ("f4", "f8", "f4", "u1", "i4")]
    data = b"".join(np.array(x, kind).tobytes() for row in VERTICES for x, kind in zip(row, kinds, strict=True))
    for corners, number in faces:
        data += np.array([1, len(corners)], "u1").tobytes() + np.array(corners, order + "i4").tobytes()
        data += np.array(number, order + "u2").tobytes()
    return data


def written(path: Path, flavour: str, faces: list[tuple[list[int], int]]) -> Path:
    path.write_bytes(header(flavour, len(VERTICES), len(faces)) + body(flavour, faces))
    return path


@pytest.mark.parametrize("flavour", FLAVOURS)
@pytest.mark.parametrize("faces", [FACES, QUADS, MIXED, []], ids=["triangles", "quads", "mixed", "none"])
def test_every_flavour_reads_alike(tmp_path: Path, flavour: str, faces: list[tuple[list[int], int]]) -> None:
    path = written(tmp_path / "a.ply", flavour, faces)
    mesh: Ply = read_ply(path)
    np.testing.assert_array_equal(mesh.points(path), np.array([row[:3] for row in VERTICES], np.float32))
    assert mesh.column("label", path).tolist() == [1000, 70000, 5, 6]
    assert mesh.vertices["red"].tolist() == [7, 200, 0, 9]
    fans = [((c[0], c[i], c[i + 1]), number) for c, number in faces for i in range(1, len(c) - 1)]
    assert mesh.triangles.reshape(-1, 3).tolist() == [list(corners) for corners, _ in fans]
    assert mesh.triangles.dtype == np.int32
    if faces:
        assert mesh.of_face["object_id"].tolist() == [number for _, number in fans]


@pytest.mark.parametrize("ascii_file", [True, False])
def test_a_mesh_that_open3d_wrote(tmp_path: Path, ascii_file: bool) -> None:
    sphere = o3d.geometry.TriangleMesh.create_sphere(1.0, 5)
    sphere.compute_vertex_normals()
    sphere.paint_uniform_color((1.0, 0.5, 0.0))
    path = tmp_path / "a.ply"
    o3d.io.write_triangle_mesh(str(path), sphere, write_ascii=ascii_file)
    mesh = read_ply(path)
    np.testing.assert_allclose(mesh.points(path), np.asarray(sphere.vertices), atol=1e-6)
    np.testing.assert_array_equal(mesh.triangles, np.asarray(sphere.triangles))
    assert set(mesh.column("red", path)) == {255}


@pytest.mark.parametrize("flavour", FLAVOURS)
@pytest.mark.parametrize("faces", [FACES, MIXED], ids=["triangles", "mixed"])
def test_a_file_that_is_cut_short_is_one_line(tmp_path: Path, flavour: str, faces: list[tuple[list[int], int]]) -> None:
    whole = written(tmp_path / "a.ply", flavour, faces).read_bytes()
    for cut in (3, 12, 40, len(whole) - 20):
        path = tmp_path / "cut.ply"
        path.write_bytes(whole[:-cut])
        with pytest.raises(BadInput, match=r"cut\.ply is no PLY file, or is cut short") as caught:
            read_ply(path)
        assert "\n" not in str(caught.value)


def test_other_files_and_corners_without_vertices_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.ply").write_text("solid stl\n")
    with pytest.raises(BadInput, match="no PLY file"):
        read_ply(tmp_path / "a.ply")
    with pytest.raises(BadInput, match="cannot be read"):
        read_ply(tmp_path / "nowhere.ply")
    path = written(tmp_path / "b.ply", "ascii", [([0, 1, 44], 1)])
    with pytest.raises(BadInput, match="no vertices of it"):
        read_ply(path)


def test_a_cloud_has_no_triangles(tmp_path: Path) -> None:
    lines = ["ply", "format ascii 1.0", "element vertex 1", "property float x", "property float y", "property float z"]
    (tmp_path / "a.ply").write_text("\n".join([*lines, "end_header", "1 2 3", ""]))
    mesh = read_ply(tmp_path / "a.ply")
    assert (mesh.points(tmp_path).tolist(), len(mesh.triangles)) == ([[1, 2, 3]], 0)
    with pytest.raises(BadInput, match="no vertex property label: it has x, y, z"):
        mesh.column("label", tmp_path)
