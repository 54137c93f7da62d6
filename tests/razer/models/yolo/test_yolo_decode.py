"""Decoding of YOLO outputs against a literal reading of what they mean, number by number and pixel by pixel."""

from __future__ import annotations

import math

import numpy as np
import pytest

from razer.models.yolo.decoder import YoloDecoder
from razer.models.yolo.letterbox import Letterbox
from razer.models.yolo.prototype_masks import prototype_masks

INPUT = (64, 96)
GRID = (16, 24)
NAMES = tuple(f"class {i}" for i in range(5))
N_PROTOTYPES = 6
Box = tuple[float, float, float, float]


def outputs(seed: int, layout: str, n_classes: int, n_things: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Random predictions, half of them unsure, with boxes that overlap, and smooth prototypes."""
    rng = np.random.default_rng(seed)
    corner = rng.uniform(-5, [80, 50], (n_things, 2))
    size = rng.uniform(8, 45, (n_things, 2))
    corner[1::4], size[1::4] = corner[::4] + rng.uniform(-3, 3, size[::4].shape), size[::4]  # doubles
    scores = rng.uniform(0, 1, (n_things, n_classes)) * rng.uniform(0.2, 1, (n_things, 1))
    coefficients = rng.normal(0, 1, (n_things, N_PROTOTYPES))
    if layout == "dense":
        rows = np.concatenate([corner + size / 2, size, scores, coefficients], axis=1).T
    else:
        best = np.stack([scores.max(axis=1), scores.argmax(axis=1)], axis=1)
        rows = np.concatenate([corner, corner + size, best, coefficients], axis=1)
    wave = np.mgrid[: GRID[0], : GRID[1]].reshape(2, -1)
    prototypes = np.sin(rng.uniform(-0.7, 0.7, (N_PROTOTYPES, 2)) @ wave + rng.uniform(0, 6, (N_PROTOTYPES, 1)))
    return rows[None].astype(np.float32), prototypes.reshape(1, N_PROTOTYPES, *GRID).astype(np.float32)


def overlap(a: Box, b: Box) -> float:
    wide, high = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    if wide <= 0 or high <= 0:
        return 0.0
    both = wide * high
    return both / ((a[2] - a[0]) * (a[3] - a[1]) + (b[2] - b[0]) * (b[3] - b[1]) - both)


def literal_candidates(rows: np.ndarray, layout: str, confidence: float, iou: float) -> list:
    """(score, class, box in the input, coefficients) of what is left, best first."""
    candidates = []
    if layout == "dense":
        for anchor in range(rows.shape[1]):
            cx, cy, w, h, *scores = rows[:-N_PROTOTYPES, anchor].tolist()
            score = max(scores)
            box = (cx - w / 2, cy - h / 2, cx + w / 2, cy + h / 2)
            candidates.append((score, scores.index(score), box, rows[-N_PROTOTYPES:, anchor]))
    else:
        candidates = [(float(row[4]), int(row[5]), tuple(row[:4].tolist()), row[6:]) for row in rows]
    left: list = []
    for one in sorted((f for f in candidates if f[0] >= confidence), key=lambda f: -f[0]):
        doubles = [o for o in left if o[1] == one[1] and overlap(o[2], one[2]) > iou]
        if layout != "dense" or not doubles:
            left.append(one)
    return left


def literal_mask(values: np.ndarray, box: Box, letterbox: Letterbox) -> np.ndarray:
    """Every pixel of the image by itself: where its centre lies in the input and in the grid, what is there."""
    rows, columns = letterbox.image
    mask = np.zeros((rows, columns), bool)
    for row in range(rows):
        for column in range(columns):
            x = (column + 0.5) * letterbox.content[1] / columns + letterbox.left
            y = (row + 0.5) * letterbox.content[0] / rows + letterbox.top
            if box[0] < x < box[2] and box[1] < y < box[3]:
                mask[row, column] = between(values, x / INPUT[1] * GRID[1] - 0.5, y / INPUT[0] * GRID[0] - 0.5) > 0
    return mask


def between(values: np.ndarray, x: float, y: float) -> float:
    """The value between the centres of cells, by their distances; the outermost cells go on for ever."""
    total = 0.0
    for i in (math.floor(y), math.floor(y) + 1):
        for j in (math.floor(x), math.floor(x) + 1):
            cell = values[min(max(i, 0), GRID[0] - 1), min(max(j, 0), GRID[1] - 1)]
            total += float(cell) * (1 - abs(y - i)) * (1 - abs(x - j))
    return total


@pytest.mark.parametrize("image", [(64, 96), (48, 60), (60, 40), (97, 151)], ids=str)
@pytest.mark.parametrize(("layout", "n_classes"), [("dense", 5), ("dense", 1), ("end to end", 5)])
def test_decoding_agrees_with_a_literal_reading(layout: str, n_classes: int, image: tuple[int, int]) -> None:
    predictions, prototypes = outputs(n_classes + image[0], layout, n_classes)
    letterbox = Letterbox.of(image, INPUT)
    masks = YoloDecoder("test", NAMES[:n_classes], 0.4, 0.5, 100).masks(predictions, prototypes, letterbox)
    expected = []
    for score, number, box, coefficients in literal_candidates(predictions[0], layout, 0.4, 0.5):
        mask = literal_mask(np.tensordot(coefficients, prototypes[0], 1), box, letterbox)
        if mask.any():
            expected.append((score, NAMES[number], mask))
    assert len(expected) > 5
    assert masks.class_names == tuple(name for _, name, _ in expected)
    np.testing.assert_allclose(masks.scores, [score for score, _, _ in expected], atol=1e-6)
    for mask, (_, _, literal) in zip(masks.masks, expected, strict=True):
        assert np.count_nonzero(mask & literal) / np.count_nonzero(mask | literal) > 0.99


def test_doubles_are_of_one_class_only() -> None:
    boxes = np.array([[10, 10, 50, 50], [12, 10, 52, 50], [11, 10, 51, 50], [60, 10, 90, 50]], np.float32)
    rows = np.zeros((1, 4 + 2 + 1, 4), np.float32)
    rows[0, :2], rows[0, 2:4] = (boxes[:, :2] + boxes[:, 2:]).T / 2, (boxes[:, 2:] - boxes[:, :2]).T
    rows[0, 4], rows[0, 5], rows[0, 6] = [0.9, 0.8, 0, 0.5], [0, 0, 0.7, 0], 1
    ones = np.ones((1, 1, *GRID), np.float32)

    def names(iou: float) -> tuple[str, ...] | None:
        decoder = YoloDecoder("test", ("cup", "bowl"), 0.25, iou, 100)
        return decoder.masks(rows, ones, Letterbox.of(INPUT, INPUT)).class_names

    assert names(0.7) == ("cup", "bowl", "cup")
    assert names(0.95) == ("cup", "cup", "bowl", "cup")


def test_a_mask_ends_where_its_box_ends() -> None:
    boxes = np.array([[10.4, 3.6, 20.6, 9.5], [-50, -50, 500, 500], [30, 30, 30, 40], [200, 0, 300, 9]], np.float32)
    masks = prototype_masks(
        np.ones((4, 1), np.float32), np.ones((1, *GRID), np.float32), boxes, Letterbox.of(INPUT, INPUT)
    )
    expected = np.zeros(INPUT, bool)
    expected[4:10, 10:21] = True  # from the first centre inside to the last
    np.testing.assert_array_equal(masks[0], expected)
    assert masks[1].all()
    assert not masks[2:].any()


def test_nothing_found_is_no_masks() -> None:
    predictions, prototypes = outputs(0, "dense", 5)
    masks = YoloDecoder("test", NAMES, 1.0, 0.5, 100).masks(predictions, prototypes, Letterbox.of((48, 60), INPUT))
    assert (masks.masks.shape, masks.class_names) == ((0, 48, 60), ())


@pytest.mark.parametrize("image", [(480, 640), (640, 480), (968, 1296), (7, 500), (1, 1)], ids=str)
@pytest.mark.parametrize("stride", [(None, None), (32, 32), (None, 32)], ids=str)
def test_a_letterbox_holds_the_image_as_large_as_can_be(
    image: tuple[int, int], stride: tuple[int | None, int | None]
) -> None:
    most = (640, 512)
    letterbox = Letterbox.of(image, most, stride)
    for side in (0, 1):
        assert letterbox.content[side] <= letterbox.input[side] <= most[side]
        assert letterbox.input[side] == most[side] if stride[side] is None else letterbox.input[side] % 32 == 0
    assert any(letterbox.content[side] == most[side] for side in (0, 1))
    scale = min(most[0] / image[0], most[1] / image[1])
    assert abs(letterbox.content[0] - max(image[0] * scale, 1)) <= 0.5
    spare = [letterbox.input[side] - letterbox.content[side] for side in (0, 1)]
    assert (letterbox.top, letterbox.left) == (spare[0] // 2, spare[1] // 2)
    inside = [
        letterbox.left,
        letterbox.top,
        letterbox.left + letterbox.content[1],
        letterbox.top + letterbox.content[0],
    ]
    np.testing.assert_array_equal(letterbox.boxes_in_image(np.array([inside])), [[0, 0, image[1], image[0]]])
