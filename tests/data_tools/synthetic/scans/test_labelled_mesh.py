"""Labelled meshes of many kinds: whose a vertex is, what that is called, and which colour it has."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from data_tools.synthetic.scans.connected_parts import connected_parts
from data_tools.synthetic.scans.labelled_mesh import open_labelled_mesh, renumbered, stated_up
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.open_truth import open_truth
from data_tools.truth.ply import Ply
from data_tools.truth.ply_writer import write_ply
from data_tools.truth.truth_folder import write_truth
from data_tools.truth.vertex_colors import vertex_colors
from data_tools.writers.scannet_truth import write_scannet_truth
from razer.errors import BadInput
from tests.support.labelled_meshes import furnished_room

ROOM = furnished_room(0.15)
RGB = dict(zip(("red", "green", "blue"), ROOM.colors.T, strict=True))  # type: ignore[union-attr]
Writer = Callable[[Path], None]


def written(path: Path, properties: dict, of_face: dict | None = None, points: np.ndarray = ROOM.vertices) -> Path:
    write_ply(path, points, properties, ROOM.triangles, of_face)
    return path


@pytest.mark.parametrize("name", ["instance", "object_id", "objectId", "Instance_ID"])
@pytest.mark.parametrize("kind", ["<i4", "<u2", "<f4"])
def test_instances_have_many_names_and_types(tmp_path: Path, name: str, kind: str) -> None:
    truth = open_labelled_mesh(written(tmp_path / "scan.ply", {name: ROOM.instances.astype(kind)}))
    np.testing.assert_array_equal(truth.instances, ROOM.instances)
    assert truth.instance_classes == dict.fromkeys(range(1, 9), "object")
    assert truth.colors is None


def test_instances_of_faces_become_those_of_vertices(tmp_path: Path) -> None:
    of_face = {"objectId": ROOM.instances[ROOM.triangles[:, 0]]}
    truth = open_labelled_mesh(written(tmp_path / "scan.ply", {}, of_face))
    used = np.unique(ROOM.triangles)
    np.testing.assert_array_equal(truth.instances[used], ROOM.instances[used])


def test_names_come_from_files_beside_the_mesh(tmp_path: Path) -> None:
    both = {"instance": ROOM.instances, "label": ROOM.classes}
    mesh = written(tmp_path / "scan.ply", both)
    assert open_labelled_mesh(mesh).instance_classes[1] == f"class {ROOM.classes[ROOM.instances == 1][0]}"
    (tmp_path / "classes.json").write_text(json.dumps({str(k): name for k, name in ROOM.class_names.items()}))
    assert open_labelled_mesh(mesh).instance_classes == ROOM.instance_classes
    run = {"instances": [{"id": 6, "class": "desk"}, {"id": 7, "class": None}], "up": [0, -0.9, -0.44]}
    mesh = written(tmp_path / "mesh.ply", {"instance": ROOM.instances})
    (tmp_path / "instances.json").write_text(json.dumps(run))
    classes = open_labelled_mesh(mesh).instance_classes
    assert (classes[6], classes[7]) == ("desk", "object")
    assert stated_up(mesh) == (0, -0.9, -0.44)
    assert stated_up(tmp_path / "elsewhere/mesh.ply") is None
    (tmp_path / "classes.json").write_text('{"one": "chair"}')
    with pytest.raises(BadInput, match=r"classes.json must map"):
        open_labelled_mesh(written(tmp_path / "scan.ply", both))


def test_connected_parts_of_a_class_are_instances(tmp_path: Path) -> None:
    """ScanNet's labels are those of NYU40: 1 wall, 2 floor, 5 chair, 7 table."""
    number = np.array([0, 2, 1, 1, 1, 1, 7, 5, 5], np.int32)[ROOM.instances]
    truth = open_labelled_mesh(written(tmp_path / "scene0000_00_vh_clean_2.labels.ply", {"label": number}))
    assert "connected part" in truth.notes[0]
    assert set(truth.instance_classes.values()) == {"wall", "floor", "chair", "table"}
    for instance in (1, 6, 7, 8):
        mine = truth.instances[ROOM.instances == instance]
        assert len(np.unique(mine)) == 1
        assert (truth.instances == mine[0]).sum() == len(mine)
    # Walls that meet in a corner are one.
    in_faces = np.isin(np.arange(len(number)), ROOM.triangles)
    assert len(np.unique(truth.instances[(number == 1) & in_faces])) == 1


def test_parts_are_divided_by_gaps_and_labels_but_not_by_cracks() -> None:
    x, y = np.meshgrid(np.arange(10) * 0.05, np.arange(4) * 0.05, indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), np.zeros(40)], axis=1)
    corner = np.arange(40).reshape(10, 4)[:-1, :-1].ravel()
    quads = np.stack([corner, corner + 4, corner + 5, corner, corner + 5, corner + 1], axis=1).reshape(-1, 3)
    near, far = (points + np.array([along, 0, 0]) for along in (0.46, 2.0))
    crumb = np.array([[5.0, 0, 0], [5.01, 0, 0], [5, 0.01, 0]])
    everything = np.concatenate([points, near, far, crumb]).astype(np.float32)
    triangles = np.concatenate([quads, quads + 40, quads + 80, [[120, 121, 122]]]).astype(np.int32)
    labels = np.full(123, 3, np.int32)
    parts = connected_parts(everything, triangles, labels)
    assert (parts[:80] == parts[0]).all()
    assert parts[80] not in (0, parts[0])
    assert (parts[120:] == 0).all()
    labels[40:80], labels[80:] = 4, 0
    parts = connected_parts(everything, triangles, labels)
    assert sorted({*parts[:40].tolist()} | {*parts[40:80].tolist()}) == [1, 2]
    assert (parts[80:] == 0).all()


def write_own(folder: Path) -> None:
    write_truth(ROOM, folder)


def write_scannet(folder: Path) -> None:
    write_scannet_truth(ROOM, folder, "scene0001_00")


def write_scenenn(folder: Path) -> None:
    written(folder / "005.ply", {"label": ROOM.instances.astype("<u2"), **RGB})
    rows = "".join(f'<label id="{i}" text="{name}" nyu_class="{name}"/>' for i, name in ROOM.instance_classes.items())
    (folder / "005.xml").write_text(f"<annotation>{rows}</annotation>")
    written(folder / "001.ply", {"label": ROOM.instances})


def write_replica(folder: Path) -> None:
    written(folder / "mesh_semantic.ply", RGB, {"object_id": ROOM.instances[ROOM.triangles[:, 0]]})
    names = {name: number for number, name in ROOM.class_names.items()}
    objects = [{"id": i, "class_id": names[name], "class_name": name} for i, name in ROOM.instance_classes.items()]
    (folder / "info_semantic.json").write_text(json.dumps({"objects": objects}))


@pytest.mark.parametrize(
    ("write", "name"),
    [
        (write_own, "mesh.ply"),
        (write_scannet, "scene0001_00_vh_clean_2.ply"),
        (write_scenenn, "005.ply"),
        (write_replica, "mesh_semantic.ply"),
    ],
)
def test_meshes_of_known_datasets_are_read_as_their_truth(tmp_path: Path, write: Writer, name: str) -> None:
    write(tmp_path)
    expected = open_truth(tmp_path)
    for path in (tmp_path, tmp_path / name):
        truth = open_labelled_mesh(path)
        np.testing.assert_array_equal(truth.instances, expected.instances)
        assert truth.instance_classes == expected.instance_classes
        assert len(truth.instance_classes) == 8
        assert truth.colors is not None
    used = np.unique(ROOM.triangles)
    assert (truth.instances[used] == ROOM.instances[used]).mean() == 1
    np.testing.assert_allclose(open_labelled_mesh(tmp_path / name, 0.5).vertices, ROOM.vertices / 2)


@pytest.mark.parametrize(
    ("names", "convert"),
    [
        (("red", "green", "blue"), lambda c: c),
        (("r", "g", "b"), lambda c: c.astype(np.float32) / 255),
        (("diffuse_red", "diffuse_green", "diffuse_blue"), lambda c: c.astype(np.float64)),
        (("Red", "Green", "Blue"), lambda c: c.astype(np.uint16) * 257),
    ],
)
def test_colours_have_many_names_and_types(names: tuple[str, ...], convert: Callable) -> None:
    assert ROOM.colors is not None
    columns = dict(zip(names, convert(ROOM.colors).T, strict=True))
    nothing = np.zeros((0, 3), np.int32)
    colors = vertex_colors(Ply({"x": ROOM.vertices[:, 0], **columns}, nothing, {}, np.zeros(0, np.int32)))
    assert colors is not None
    assert np.abs(colors.astype(int) - ROOM.colors).max() <= 1


def test_colours_of_faces_become_means_of_those_round_a_vertex() -> None:
    faces = {"red": np.array([100, 200]), "green": np.array([0, 0]), "blue": np.array([255, 255])}
    mesh = Ply({"x": np.zeros(5)}, np.array([[0, 1, 2], [1, 2, 3]], np.int32), faces, np.arange(2, dtype=np.int32))
    colors = vertex_colors(mesh)
    assert colors is not None
    assert colors[:, 0].tolist() == [100, 150, 150, 200, 0]
    assert colors[:4, 2].tolist() == [255] * 4


def test_large_numbers_are_counted_anew_and_small_ones_kept() -> None:
    assert renumbered(ROOM, 8) is ROOM
    large = replace(ROOM, instances=np.where(ROOM.instances > 1, ROOM.instances * 100_000, 0).astype(np.int32))
    small: GroundTruth = renumbered(large, 65535)
    np.testing.assert_array_equal(small.instances, np.where(ROOM.instances > 1, ROOM.instances - 1, 0))
    assert "anew" in small.notes[-1]
