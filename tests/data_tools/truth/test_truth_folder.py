"""The project's own truth/ folder, written by others: any PLY with `instance` and `class` on its vertices."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from data_tools.truth.open_truth import open_truth
from data_tools.truth.truth_folder import read_truth
from razer.errors import BadInput

HEADER = """ply
format ascii 1.0
comment by hand
element vertex 4
property double x
property double y
property double z
property uchar red
property short class
property ushort instance
{more}element face 1
property list uchar uint vertex_index
end_header
"""
ROWS = ["0 0 0 9 5 300", "1 0 0 9 5 300", "1 1 0 9 7 2", "0 1 0 9 0 0"]


def write_truth_by_hand(folder: Path, more: str = "", visible: tuple[str, ...] = ("", "", "", "")) -> Path:
    folder.mkdir(parents=True)
    rows = [f"{row} {seen}" for row, seen in zip(ROWS, visible, strict=True)]
    (folder / "mesh.ply").write_text(HEADER.format(more=more) + "\n".join(rows) + "\n4 0 1 2 3\n")
    (folder / "classes.json").write_text(json.dumps({"5": "chair", "7": "couch"}))
    return folder


def test_a_mesh_by_others_counts_as_seen_throughout(tmp_path: Path) -> None:
    write_truth_by_hand(tmp_path / "room" / "truth")
    truth = open_truth(tmp_path / "room")
    assert (truth.instances.tolist(), truth.classes.tolist()) == ([300, 300, 2, 0], [5, 5, 7, 0])
    assert truth.instance_classes == {300: "chair", 2: "couch"}
    assert truth.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert truth.visible.all()


def test_visible_is_taken_where_it_is_there(tmp_path: Path) -> None:
    folder = write_truth_by_hand(tmp_path / "truth", "property uchar visible\n", ("0", "1", "1", "0"))
    assert read_truth(folder).visible.tolist() == [False, True, True, False]


def test_a_class_without_name_is_called_by_its_number(tmp_path: Path) -> None:
    folder = write_truth_by_hand(tmp_path / "truth")
    (folder / "classes.json").write_text(json.dumps({"5": "chair"}))
    truth = read_truth(folder)
    assert truth.instance_classes == {300: "chair", 2: "class 7"}
    assert truth.notes == ("classes.json has no name for class 7",)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("classes.json", "[1, 2]", r"classes\.json must map class numbers to names"),
        ("classes.json", '{"chair": 5}', r"classes\.json must map class numbers to names"),
        ("mesh.ply", HEADER.replace("ushort instance", "ushort object"), r"mesh\.ply is no PLY file, or is cut short"),
        ("mesh.ply", None, r"mesh\.ply is missing"),
        ("classes.json", None, r"classes\.json is missing"),
    ],
)
def test_what_is_no_truth_is_one_line(tmp_path: Path, name: str, text: str | None, message: str) -> None:
    path = write_truth_by_hand(tmp_path / "truth") / name
    path.unlink() if text is None else path.write_text(text)
    with pytest.raises(BadInput, match=message) as caught:
        read_truth(tmp_path / "truth")
    assert "\n" not in str(caught.value)


def test_a_mesh_without_instances_says_which_property_is_missing(tmp_path: Path) -> None:
    path = write_truth_by_hand(tmp_path / "truth") / "mesh.ply"
    path.write_text(path.read_text().replace("ushort instance", "ushort object"))
    with pytest.raises(BadInput, match=r"no vertex property instance: it has x, y, z, red, class, object"):
        read_truth(tmp_path / "truth")
