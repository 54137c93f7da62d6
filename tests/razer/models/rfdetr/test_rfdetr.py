"""The rfdetr segmenter on ONNX files with the published signature, and on files that are none."""

from __future__ import annotations

import pickle
from pathlib import Path

import cv2
import numpy as np
import pytest

from razer.errors import BadInput
from razer.frame import Frame, Intrinsics
from razer.models import make_segmenter
from razer.models.rfdetr.decoder import decode_queries
from tests.support.rfdetr_exports import CHAIR, CUP, TOOTHBRUSH, logits, write_rfdetr

ONE_OF_EACH = logits([{CHAIR: 0.8}, {CUP: 0.6, CHAIR: 0.3}, {TOOTHBRUSH: 0.9}])


def picture(width: int = 160, height: int = 120) -> Frame:
    """A grey picture with a red patch and a blue one, at the same share of its sides whatever its size."""
    rgb = np.full((120, 160, 3), 120, np.uint8)
    rgb[20:60, 10:70], rgb[70:110, 90:150] = (220, 40, 60), (30, 40, 230)
    rgb = cv2.resize(rgb, (width, height), interpolation=cv2.INTER_NEAREST)
    return Frame(0, 0.0, rgb, np.ones((height, width), np.float32), Intrinsics(width, height, 100, 100, 80, 60))


def made(file: Path, labels: np.ndarray = ONE_OF_EACH, options: dict | None = None, **export: object):
    return make_segmenter("rfdetr", {"weights": str(write_rfdetr(file, labels, **export)), **(options or {})})


def iou(a: np.ndarray, b: np.ndarray) -> float:
    return np.count_nonzero(a & b) / np.count_nonzero(a | b)


@pytest.mark.parametrize("size", [(160, 120), (120, 160), (321, 243)], ids=str)
@pytest.mark.parametrize("export", [{}, {"side": 128}, {"names": ("dets", "labels", "4245")}], ids=str)
def test_each_query_is_a_mask_of_its_best_class(tmp_path: Path, size: tuple[int, int], export: dict) -> None:
    frame = picture(*size)
    masks = made(tmp_path / "m.onnx", **export).segment(frame)
    # The toothbrush's mask is empty: the last of COCO's numbers is a class, not "no object".
    assert masks.class_names == ("chair", "cup")
    np.testing.assert_allclose(masks.scores, [0.8, 0.6], atol=1e-5)
    assert iou(masks.masks[0], frame.rgb[..., 0] > 200) > 0.9
    assert iou(masks.masks[1], frame.rgb[..., 2] > 200) > 0.9


def test_decoding_agrees_with_pixel_by_pixel() -> None:
    random = np.random.default_rng(0)
    labels, masks = random.normal(size=(9, 5)).astype(np.float32), random.normal(size=(9, 3, 4)).astype(np.float32)
    names = ("a", "", "b", "c", "")
    found = decode_queries(labels, masks, names, (6, 8), confidence=0.6, max_masks=4)
    expected = []
    for row, mask in zip(labels, masks, strict=True):
        score, column = max((1 / (1 + np.exp(-row[c])), c) for c in (0, 2, 3))
        if score >= 0.6:
            expected.append((score, names[column], [[_bilinear(mask, y, x) > 0 for x in range(8)] for y in range(6)]))
    expected = sorted((each for each in expected if np.any(each[2])), key=lambda each: -each[0])[:4]
    np.testing.assert_allclose(found.scores, [score for score, *_ in expected], atol=1e-6)
    assert found.class_names == tuple(name for _, name, _ in expected)
    np.testing.assert_array_equal(found.masks, [mask for *_, mask in expected])


def _bilinear(grid: np.ndarray, y: int, x: int) -> float:
    """The grid at a pixel of an image of twice its size, by pixel centres; beyond the border as at it."""
    total, rows, columns = 0.0, *grid.shape
    v, u = (y + 0.5) / 2 - 0.5, (x + 0.5) / 2 - 0.5
    for row in (int(np.floor(v)), int(np.floor(v)) + 1):
        for column in (int(np.floor(u)), int(np.floor(u)) + 1):
            share = (1 - abs(v - row)) * (1 - abs(u - column))
            total += share * grid[min(max(row, 0), rows - 1), min(max(column, 0), columns - 1)]
    return total


def test_confidence_and_number_of_masks_limit_what_is_found(tmp_path: Path) -> None:
    tries = ({"confidence": 0.7}, {"max_masks": 1}, {"confidence": 0.95})
    found = [made(tmp_path / "m.onnx", options=each).segment(picture()).class_names for each in tries]
    assert found == [("chair",), ("chair",), ()]


def test_classes_of_ones_own_leave_the_last_column_to_no_object(tmp_path: Path) -> None:
    labels = logits([{1: 0.7, 2: 0.99}, {0: 0.8}], n_columns=3)
    (tmp_path / "names.txt").write_text("valve\npump\n")
    for options, metadata in (({"names": str(tmp_path / "names.txt")}, {}), ({}, {"names": "['valve', 'pump']"})):
        masks = made(tmp_path / "m.onnx", labels, options, metadata=metadata).segment(picture())
        assert masks.class_names == ("valve", "pump")
        np.testing.assert_allclose(masks.scores, [0.8, 0.7], atol=1e-5)


def test_it_travels_to_another_process(tmp_path: Path) -> None:
    segmenter = made(tmp_path / "m.onnx")
    expected = segmenter.segment(picture())
    again = pickle.loads(pickle.dumps(segmenter)).segment(picture())
    np.testing.assert_array_equal(again.masks, expected.masks)


@pytest.mark.parametrize(
    ("labels", "export", "options", "message"),
    [
        (ONE_OF_EACH, {"drop_masks": True}, {}, "no RF-DETR segmentation model: expected dets, labels and masks"),
        (ONE_OF_EACH, {"side": "open"}, {}, "RF-DETR takes one square colour image"),
        (logits([{0: 0.9}], 7), {}, {}, "does not say what its classes are called"),
        (logits([{0: 0.9}], 7), {"metadata": {"names": "['a', 'b']"}}, {}, "7 columns apart, but 2 names"),
        (ONE_OF_EACH, {}, {"confidence": 0}, "confidence above 0"),
        (ONE_OF_EACH, {}, {"max_masks": 0}, "max_masks >= 1"),
    ],
)
def test_what_cannot_be_used_is_one_line(
    tmp_path: Path, labels: np.ndarray, export: dict, options: dict, message: str
) -> None:
    with pytest.raises(BadInput, match=message) as refused:
        made(tmp_path / "m.onnx", labels, options, **export)
    assert "\n" not in str(refused.value)
