"""Ground truth of ScanNet: meshes, segments, objects and label maps, real, hand-made and damaged."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.truth.class_names import category_of
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.label_map import FILE_NAME, read_label_map
from data_tools.truth.open_truth import has_truth, open_truth
from data_tools.truth.ply_writer import write_ply
from data_tools.truth.scannet_truth import read_scannet_truth
from data_tools.writers.scannet import write_scannet
from data_tools.writers.scannet_truth import write_scannet_truth
from razer.errors import BadInput
from razer.vocabulary import vocabulary

SCENE = "scene0123_00"
SEGMENTS = [7, 7, 40, 40, 3, 3, 99, 12]
# Segment 3 is in two objects; the later one has it. Segment 12 is nobody's.
OBJECTS = [(0, "office chair", [7]), (1, "wall", [40, 3]), (4, "kitchen counter", [3]), (2, "doorframe", [99])]
TSV = """id\traw_category\tcategory\tcount\tnyu40id
10\toffice chair\toffice chair\t595\t5
1\twall\twall\t8277\t1
159\tkitchen counter\tkitchen counter\t140\t12
161\tdoorframe\tdoorframe\t768\t8
9999\twall\twall\t1\t40
"""


def write_scene(
    folder: Path,
    segments: list[int] = SEGMENTS,
    objects: list[tuple[int, str, list[int]]] = OBJECTS,
    tsv: str | None = TSV,
    vertices: int = 8,
    ends: tuple[str, str, str] = ("_vh_clean_2.ply", "_vh_clean_2.0.010000.segs.json", ".aggregation.json"),
) -> Path:
    folder.mkdir(parents=True)
    points = np.stack([np.arange(vertices, dtype=np.float32)] * 3, axis=1)
    colors = {name: np.full(vertices, 200, np.uint8) for name in ("red", "green", "blue", "alpha")}
    write_ply(folder / f"{SCENE}{ends[0]}", points, colors, np.array([[0, 1, 2], [5, 6, 7]], np.int32))
    (folder / f"{SCENE}{ends[1]}").write_text(json.dumps({"sceneId": SCENE, "segIndices": segments}))
    groups = [{"id": i, "objectId": n, "segments": s, "label": label} for i, (n, label, s) in enumerate(objects)]
    (folder / f"{SCENE}{ends[2]}").write_text(json.dumps({"sceneId": f"scannet.{SCENE}", "segGroups": groups}))
    if tsv is not None:
        (folder.parent / FILE_NAME).write_text(tsv)
    return folder


def test_segments_become_instances_and_raw_names_classes(tmp_path: Path) -> None:
    truth = open_truth(write_scene(tmp_path / SCENE))
    assert truth.instances.tolist() == [1, 1, 2, 2, 5, 5, 3, 0]
    assert truth.classes.tolist() == [10, 10, 1, 1, 159, 159, 161, 0]
    assert truth.class_names == {10: "office chair", 1: "wall", 159: "kitchen counter", 161: "doorframe"}
    assert truth.triangles.tolist() == [[0, 1, 2], [5, 6, 7]]
    np.testing.assert_array_equal(truth.vertices[:, 2], np.arange(8))
    assert truth.visible.all()
    assert truth.notes == ()


@pytest.mark.parametrize(
    ("name", "classes"),
    [("nyu40", [5, 5, 1, 1, 12, 12, 8, 0]), ("scannet20", [5, 5, 1, 1, 12, 12, 8, 0]),
     ("replica", [20, 20, 93, 93, 0, 0, 0, 0])],
)  # fmt: skip
def test_other_vocabularies_take_the_number_of_their_column(tmp_path: Path, name: str, classes: list[int]) -> None:
    truth = open_truth(write_scene(tmp_path / SCENE), vocabulary=name)
    assert truth.classes.tolist() == classes
    assert {i: vocabulary(name).by_id[i].name for i in set(classes) - {0}} == truth.class_names


def test_a_class_that_is_not_in_the_list_leaves_its_instance_without(tmp_path: Path) -> None:
    tsv = TSV + "29999\tmargarita\tcup\t1\t40\n"
    truth = open_truth(write_scene(tmp_path / SCENE, objects=[(0, "margarita", [7]), (1, "wall", [40])], tsv=tsv))
    assert truth.instances.tolist() == [1, 1, 2, 2, 0, 0, 0, 0]
    assert truth.classes.tolist() == [0, 0, 1, 1, 0, 0, 0, 0]
    assert (truth.notes, truth.instance_classes) == ((), {2: "wall"})


def test_unknown_names_are_counted_and_not_fatal(tmp_path: Path) -> None:
    objects = [(0, "zorb", [7]), (1, "wall", [40]), (2, "zorb", [3]), (3, "blip", [99])]
    truth = open_truth(write_scene(tmp_path / SCENE, objects=objects))
    assert truth.classes.tolist() == [0, 0, 1, 1, 0, 0, 0, 0]
    assert truth.notes == (f"3 objects have no class, as their names are not in {FILE_NAME}: blip, zorb",)


def test_without_label_map_names_count_and_that_is_said(tmp_path: Path) -> None:
    folder = write_scene(tmp_path / SCENE, objects=[*OBJECTS, (9, "zorb", [12])], tsv=None)
    truth = open_truth(folder)
    assert truth.classes.tolist() == [10, 10, 1, 1, 159, 159, 161, 0]
    assert [FILE_NAME in note or "zorb" in note for note in truth.notes] == [True, True]
    assert open_truth(folder, vocabulary="nyu40").classes.tolist()[:4] == [5, 5, 1, 1]
    given = tmp_path / "elsewhere.tsv"
    given.write_text(TSV)
    assert read_scannet_truth(folder, labels=given).classes[4] == 159


def test_the_full_mesh_is_read_where_the_small_one_is_not_there(tmp_path: Path) -> None:
    ends = ("_vh_clean.ply", "_vh_clean.segs.json", "_vh_clean.aggregation.json")
    assert open_truth(write_scene(tmp_path / SCENE, ends=ends)).instances.tolist() == [1, 1, 2, 2, 5, 5, 3, 0]
    mixed = ("_vh_clean_2.ply", "_vh_clean_2.0.010000.segs.json", "_vh_clean.aggregation.json")
    assert open_truth(write_scene(tmp_path / "b" / SCENE, ends=mixed)).instances[0] == 1


def test_a_scene_among_others_is_found_by_name(tmp_path: Path) -> None:
    write_scene(tmp_path / "scans" / SCENE)
    write_scene(tmp_path / "scans" / "other", objects=[(5, "wall", [7])])
    assert open_truth(tmp_path / "scans", scene=SCENE).instances[0] == 1
    assert open_truth(tmp_path / "scans", scene="other").instances[0] == 6


FAULTS: dict[str, tuple[dict[str, Any], str]] = {
    "mesh and segments of different length": (
        {"vertices": 9}, r"segs\.json is for 8 vertices but scene0123_00_vh_clean_2\.ply has 9"
    ),
    "objects of another mesh": ({"objects": [(0, "wall", [1000, 1001])]}, "names none of the segments in"),
    "no number of an object": ({"objects": [(None, "wall", [7])]}, r'aggregation\.json must be JSON with "segGroups"'),
    "negative object": ({"objects": [(-1, "wall", [7])]}, r"aggregation\.json has an objectId below 0"),
    "segments of words": ({"segments": ["a"] * 8}, r'segs\.json must be JSON with "segIndices"'),
    "label map of another kind": ({"tsv": "a,b\n1,2\n"}, r"combined\.tsv must have the tab-separated columns"),
    "label map with words for numbers": ({"tsv": TSV.replace("159", "x")}, r"combined\.tsv must have"),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_what_does_not_fit_is_one_line(tmp_path: Path, fault: str) -> None:
    changes, message = FAULTS[fault]
    folder = write_scene(tmp_path / SCENE, **changes)
    with pytest.raises(BadInput, match=message) as caught:
        open_truth(folder)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("end", ["_vh_clean_2.ply", "_vh_clean_2.0.010000.segs.json", ".aggregation.json"])
def test_a_missing_file_is_named(tmp_path: Path, end: str) -> None:
    folder = write_scene(tmp_path / SCENE)
    (folder / f"{SCENE}{end}").unlink()
    with pytest.raises(BadInput, match=f"{SCENE}{end} is missing"):
        read_scannet_truth(folder)
    assert has_truth(folder) == (end != ".aggregation.json")


def test_some_segments_that_are_not_there_are_said(tmp_path: Path) -> None:
    truth = open_truth(write_scene(tmp_path / SCENE, objects=[(0, "wall", [7, 1000, 1001])]))
    assert truth.instances.tolist() == [1, 1, 0, 0, 0, 0, 0, 0]
    assert "2 segments" in truth.notes[0]


def test_the_real_label_map_and_the_shipped_vocabularies_agree(real_data: Path) -> None:
    label_map = read_label_map(real_data / "labels" / FILE_NAME)
    found = {name: label_map.category(name, vocabulary("scannet200")) for name in label_map.rows}
    assert {category.id for category in found.values() if category} == set(vocabulary("scannet200").by_id)
    names = {name: category.name for name, category in found.items() if category}
    assert (names["office chair"], names["doors"], names["table lamp"], names["couch"]) == (
        "office chair", "door", "lamp", "couch"
    )  # fmt: skip
    nyu40 = vocabulary("nyu40")
    told = {name: label_map.category(name, nyu40) for name in ("couch", "trash can", "shower curtain", "tv")}
    assert {name: found.name for name, found in told.items() if found} == {
        "couch": "sofa", "trash can": "otherfurniture", "shower curtain": "shower curtain", "tv": "television"
    }  # fmt: skip
    # Names alone lead to the same class, for all classes of ScanNet200.
    for category in vocabulary("scannet200").categories:
        assert category_of(category.name, nyu40) in (nyu40.by_id[category.nyu40], nyu40.by_name.get(category.name))


def test_the_real_label_map_gives_a_written_room_the_same_classes(real_data: Path, tmp_path: Path) -> None:
    room = SyntheticRoom(0, 2, 64, 48)
    truth = room.truth(0.1)
    write_scannet(room, tmp_path / SCENE, truth=truth, sens=True)
    own = open_truth(tmp_path / SCENE)
    shutil.copy(real_data / "labels" / FILE_NAME, tmp_path / SCENE / FILE_NAME)
    for back in (own, open_truth(tmp_path / SCENE)):
        for name in ("vertices", "triangles", "instances"):
            np.testing.assert_array_equal(getattr(back, name), getattr(truth, name))
        assert (back.instance_classes, back.notes) == (truth.instance_classes, ())


def test_surfaces_without_instance_or_class_are_written_too(tmp_path: Path) -> None:
    points = np.zeros((6, 3), np.float32)
    instances, classes = np.array([0, 0, 3, 3, 5, 0], np.int32), np.array([2, 1, 2, 2, 0, 0], np.int32)
    names = {1: "wall", 2: "zorb"}
    truth = GroundTruth(points, np.zeros((0, 3), np.int32), instances, classes, names, np.ones(6, np.bool_))
    write_scannet_truth(truth, tmp_path, SCENE)
    back = open_truth(tmp_path)
    assert back.instances.tolist() == [7, 6, 3, 3, 5, 0]  # the wall and the zorb without instance follow the last one
    assert [back.class_names.get(c, "") for c in back.classes] == ["", "wall", "", "", "", ""]
    assert back.notes == ()
