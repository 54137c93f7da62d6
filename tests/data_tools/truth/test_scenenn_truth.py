"""SceneNN's ground truth: labels on a mesh, and the xml that names them."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import open3d as o3d
import pytest

from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.open_truth import has_truth, open_truth
from data_tools.truth.scenenn_truth import read_labels, read_scenenn_truth
from data_tools.writers.scenenn import write_scenenn
from razer.errors import BadInput
from razer.vocabulary import vocabulary

# Labels as the dataset has them: free text, its own names for some classes, objects without any class.
XML = """<?xml version="1.0" encoding="utf-8"?>
<annotation>
  <label id="1" color="255 0 0" text="Floor" nyu_class="floor" aabbox="0 0 0 1 1 0" />
  <label id="4" color="0 255 0" text="office chair" nyu_class="chair" aabbox="0 0 0 1 1 1" />
  <label id="7" color="0 0 255" text="Couch" nyu_class="sofa" aabbox="0 0 0 1 1 1" />
  <label id="9" color="9 0 0" text="ice box" nyu_class="fridge" />
  <label id="11" color="9 9 0" text="gizmo" nyu_class="prop" />
  <label id="12" color="9 9 9" text="something" nyu_class="unknown" />
</annotation>
"""
LABELS = [0, 1, 4, 7, 9, 11, 12, 99]  # 99 is not in the xml
HEADER = """ply
format ascii 1.0
comment made by hand
element vertex {vertices}
property float x
property float y
property float z
property uchar red
property ushort label
element face 2
property list uchar int vertex_indices
end_header
"""


def write_scene(folder: Path, xml: str = XML, labels: list[int] = LABELS) -> Path:
    folder.mkdir(exist_ok=True)
    lines = [f"{i} {i / 2} 0 200 {label}" for i, label in enumerate(labels)]
    text = HEADER.format(vertices=len(labels)) + "\n".join(lines) + "\n3 0 1 2\n4 4 5 6 7\n"
    (folder / "005.ply").write_text(text)
    (folder / "005.xml").write_text(xml)
    return folder


def classes_of(truth: GroundTruth) -> list[str]:
    return [truth.class_names.get(int(c), "") for c in truth.classes]


def test_labels_become_instances_and_nyu40_classes(tmp_path: Path) -> None:
    truth = read_scenenn_truth(write_scene(tmp_path))
    np.testing.assert_allclose(truth.vertices[3], [3, 1.5, 0])
    assert truth.instances.tolist() == [0, 1, 4, 7, 9, 11, 12, 0]
    assert classes_of(truth) == ["", "floor", "chair", "sofa", "refridgerator", "otherprop", "", ""]
    assert truth.classes.tolist() == [0, 2, 5, 6, 24, 40, 0, 0]
    assert truth.triangles.tolist() == [[0, 1, 2], [4, 5, 6], [4, 6, 7]]
    assert truth.visible.all()
    assert truth.instance_classes == {1: "floor", 4: "chair", 7: "sofa", 9: "refridgerator", 11: "otherprop"}


def test_another_vocabulary_takes_the_free_name_first(tmp_path: Path) -> None:
    truth = open_truth(write_scene(tmp_path), vocabulary="scannet200")
    names = classes_of(truth)
    # "office chair" and "couch" are ScanNet200 names; "ice box" is none, and no name of it is NYU40's refridgerator
    # alone unless there is one class with that number.
    assert names[1:4] == ["floor", "office chair", "couch"]
    fridges = [c.name for c in vocabulary("scannet200").categories if c.nyu40 == 24]
    assert names[4] == (fridges[0] if len(fridges) == 1 else "")
    assert all(name == "" or name in vocabulary("scannet200").by_name for name in names)


def test_only_a_mesh_with_an_xml_beside_it_is_a_truth(tmp_path: Path) -> None:
    write_scene(tmp_path)
    assert has_truth(tmp_path)
    (tmp_path / "005.xml").unlink()
    assert not has_truth(tmp_path)
    with pytest.raises(BadInput, match="no ground truth in a known layout"):
        open_truth(tmp_path)


FAULTS = {
    "xml cut off": ({"xml": XML[:300]}, r"005\.xml is no XML"),
    "label that is no number": ({"xml": XML.replace('id="4"', 'id="four"')}, r"005\.xml must be XML"),
    "fewer vertices than told": ({"labels": []}, r"005\.ply"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_damaged_files_are_one_line(tmp_path: Path, fault: str) -> None:
    changes, message = FAULTS[fault]
    with pytest.raises(BadInput, match=message) as caught:
        read_scenenn_truth(write_scene(tmp_path, **changes))
    assert "\n" not in str(caught.value)


def test_a_mesh_without_labels_is_said_so(tmp_path: Path) -> None:
    path = write_scene(tmp_path) / "005.ply"
    path.write_text(path.read_text().replace("ushort label", "ushort material"))
    with pytest.raises(BadInput, match=r"005\.ply has no vertex property label: it has x, y, z, red, material"):
        read_scenenn_truth(tmp_path)


def test_the_writer_writes_what_the_dataset_has(tmp_path: Path) -> None:
    room = SyntheticRoom(0, 2, 64, 48)
    truth = room.truth(0.1)
    write_scenenn(room, tmp_path / "061", truth=truth)
    labels = read_labels(tmp_path / "061" / "061.xml")
    assert {number: label.text for number, label in labels.items()} == truth.instance_classes
    nyu40, names = vocabulary("nyu40").by_id, vocabulary("scannet200").by_name
    for label in labels.values():
        assert label.nyu40 == (nyu40[names[label.text].nyu40].name if label.text in names else label.nyu40)
    items = {int(item.get("id", 0)): item for item in ElementTree.parse(tmp_path / "061" / "061.xml").iter("label")}
    for number, item in items.items():
        points = truth.vertices[truth.instances == number]
        box = [float(x) for x in item.get("aabbox", "").split()]
        np.testing.assert_allclose(box, [*points.min(axis=0), *points.max(axis=0)], rtol=1e-4, atol=1e-5)
    theirs = o3d.io.read_triangle_mesh(str(tmp_path / "061" / "061.ply"))
    np.testing.assert_array_equal(np.asarray(theirs.vertices, np.float32), truth.vertices)
    np.testing.assert_array_equal(np.asarray(theirs.triangles), truth.triangles)
    back = read_scenenn_truth(tmp_path / "061")
    np.testing.assert_array_equal(back.vertices, truth.vertices)
    np.testing.assert_array_equal(back.triangles, truth.triangles)
    np.testing.assert_array_equal(back.instances, truth.instances)
