"""Predictions of other systems, read from their files."""

from __future__ import annotations

import numpy as np
import pytest

from app.evaluation.class_numbers import ClassNumbers
from app.evaluation.prediction import read_prediction
from data_tools.predictions.mask_file import mask_text, read_mask
from data_tools.predictions.packed_masks import PackedMasks
from data_tools.predictions.submission import find_submission, read_submission
from data_tools.predictions.vertex_labels import read_vertex_labels
from razer.errors import BadInput

NUMBERS = ClassNumbers({2: "stool", 5: "throne", 7: "crown"}, "a list")


def write_submission(folder, name="scene0000_00"):
    (folder / "predicted_masks").mkdir(parents=True)
    (folder / "predicted_masks" / "a.txt").write_text("1\n1\n0\n0\n1\n")
    (folder / "predicted_masks" / "b.txt").write_text("0\n1\n1\n0\n0\n")
    listed = "predicted_masks/a.txt 2 0.75\n\npredicted_masks/b.txt 7 0.5\n"
    (folder / f"{name}.txt").write_text(listed)
    return folder


def test_a_submission_has_its_masks_classes_and_confidences_in_order(tmp_path):
    path = find_submission(write_submission(tmp_path / "s"), None)
    found = read_submission(path)
    assert {i: np.flatnonzero(m).tolist() for i, m in found.masks.items()} == {1: [0, 1, 4], 2: [1, 2]}
    assert (found.labels, found.scores, found.n_vertices) == ({1: 2, 2: 7}, {1: 0.75, 2: 0.5}, 5)


def test_several_scenes_ask_for_one_and_none_is_none(tmp_path):
    folder = write_submission(tmp_path / "s")
    (folder / "scene0001_00.txt").write_text("predicted_masks/a.txt 2 0.75\n")
    with pytest.raises(BadInput, match="--scene"):
        find_submission(folder, None)
    assert find_submission(folder, "scene0001_00") == folder / "scene0001_00.txt"
    assert find_submission(folder, "scene0002_00") is None
    assert find_submission(tmp_path, None) is None


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("predicted_masks/a.txt 2\n", "expected"),
        ("predicted_masks/a.txt two 0.5\n", "line 1"),
        ("predicted_masks/a.txt 2.5 0.5\n", "line 1"),
        ("predicted_masks/a.txt 2 nan\n", "line 1"),
        ("predicted_masks/c.txt 2 0.5\n", "c.txt is missing"),
        ("predicted_masks/short.txt 2 0.5\npredicted_masks/a.txt 2 0.5\n", "5 lines"),
        ("predicted_masks/words.txt 2 0.5\n", "one number a line"),
    ],
)
def test_a_broken_submission_is_one_plain_line(tmp_path, line, message):
    folder = write_submission(tmp_path / "s")
    (folder / "predicted_masks" / "short.txt").write_text("1\n0\n")
    (folder / "predicted_masks" / "words.txt").write_text("yes\nno\n")
    (folder / "scene0000_00.txt").write_text(line)
    with pytest.raises(BadInput, match=message):
        read_submission(folder / "scene0000_00.txt")


def test_numbers_from_a_thousand_on_hold_class_and_instance(tmp_path):
    (tmp_path / "labels.txt").write_text("0\n5001\n5002\n7001\n-1\n7\n")
    labels = read_vertex_labels(tmp_path / "labels.txt")
    assert labels.instances.tolist() == [0, 5001, 5002, 7001, 0, 0]
    assert labels.classes.tolist() == [0, 5, 5, 7, 0, 0]


def test_small_numbers_are_instances_alone(tmp_path):
    np.save(tmp_path / "labels.npy", np.array([0, 3, 3, 9], np.int16))
    labels = read_vertex_labels(tmp_path / "labels.npy")
    assert labels.instances.tolist() == [0, 3, 3, 9]
    assert labels.classes is None


@pytest.mark.parametrize("content", [np.zeros((2, 2), int), np.array([0.5, 1.0])])
def test_arrays_that_are_no_labels_are_refused(tmp_path, content):
    np.save(tmp_path / "labels.npy", content)
    with pytest.raises(BadInput, match="whole numbers"):
        read_vertex_labels(tmp_path / "labels.npy")


def test_class_numbers_are_those_they_are_said_to_be(tmp_path):
    (tmp_path / "labels.txt").write_text("2001\n5001\n0\n")
    found = read_prediction(tmp_path / "labels.txt", {}, 3, numbers=NUMBERS)
    assert found.class_names == {2001: "stool", 5001: "throne"}
    folder = write_submission(tmp_path / "s")
    assert read_prediction(folder, {2: "chair"}, 5, numbers=NUMBERS).class_names == {1: "stool", 2: "crown"}
    assert read_prediction(folder, {2: "chair", 7: "cup"}, 5).class_names == {1: "chair", 2: "cup"}


@pytest.mark.parametrize("form", ["{:d}\n", "{:d}\r\n", " {:d}\n", "{:d}.0\n", "{:03d}\n", "{:d}\t\n\n"])
@pytest.mark.parametrize("value", [1, 7, 255, -1])
def test_a_mask_is_where_the_number_is_not_zero_however_it_is_written(tmp_path, form, value):
    numbers = np.array([0, 1, 1, 0, 1, 0]) * value
    path = tmp_path / "mask.txt"
    for end in ("", "0\n"):
        text = "".join(form.format(n) for n in numbers) + end
        path.write_text(text.rstrip() if not end else text, newline="")
        assert read_mask(path).tolist() == [float(word) != 0 for word in text.split()]


def test_a_written_mask_is_one_line_for_each_vertex(tmp_path):
    mask = np.array([True, False, False, True])
    assert mask_text(mask) == b"1\n0\n0\n1\n"
    (tmp_path / "mask.txt").write_bytes(mask_text(mask))
    assert read_mask(tmp_path / "mask.txt").tolist() == mask.tolist()


def test_packed_masks_are_what_was_put_in_and_of_one_length():
    rng = np.random.default_rng(0)
    masks = [rng.random(1003) < share for share in (0, 0.01, 0.5, 1)]
    packed = PackedMasks()
    assert [packed.add(mask) for mask in masks] == list(packed) == [1, 2, 3, 4]
    assert all((packed[number] == mask).all() for number, mask in enumerate(masks, start=1))
    with pytest.raises(ValueError, match="1002"):
        packed.add(masks[0][1:])


def test_masks_of_another_mesh_are_refused(tmp_path):
    with pytest.raises(BadInput, match="5 lines, but the truth has 6 vertices"):
        read_prediction(write_submission(tmp_path / "s"), {}, 6, numbers=NUMBERS)


def test_numbers_can_be_classes_alone(tmp_path):
    (tmp_path / "classes.txt").write_text("0\n2\n5\n5\n")
    found = read_prediction(tmp_path / "classes.txt", {}, 4, numbers=NUMBERS, labels="class")
    assert found.instances is None
    assert found.classes.tolist() == [0, 2, 5, 5]
    assert found.vertex_class_names == {2: "stool", 5: "throne"}


def test_what_is_no_prediction_is_said_in_one_line(tmp_path):
    with pytest.raises(BadInput, match="does not exist"):
        read_prediction(tmp_path / "nothing", {}, 3)
    with pytest.raises(BadInput, match="no run folder"):
        read_prediction(tmp_path, {}, 3)
