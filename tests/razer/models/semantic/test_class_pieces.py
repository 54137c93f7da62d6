"""Class maps at the size of an image and their connected pieces, against slow references."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from razer.models.semantic.class_pieces import class_pieces, connected_pieces, resized_classes
from razer.models.semantic.class_scores import class_scores, layout_of
from razer.models.stuff_names import is_stuff_name


@pytest.mark.parametrize("as_probabilities", [False, True])
def test_logits_are_interpolated_before_they_are_compared(as_probabilities: bool) -> None:
    generator = torch.Generator().manual_seed(3)
    coarse = torch.nn.functional.interpolate(torch.randn(1, 6, 4, 5, generator=generator) * 4, (12, 15), mode="bicubic")
    scores = coarse.softmax(1) if as_probabilities else coarse
    classes, probability = resized_classes(scores[0].numpy(), 48, 60)
    expected = torch.nn.functional.interpolate(scores, (48, 60), mode="bilinear", align_corners=False)[0]
    # Classes that are best nowhere on the coarse grid do not compete.
    assert (classes == expected.argmax(0).numpy()).mean() > 0.99
    best = coarse.softmax(1).max(1, keepdim=True).values
    grown = torch.nn.functional.interpolate(best, (48, 60), mode="bilinear", align_corners=False)[0, 0]
    assert probability is not None
    np.testing.assert_allclose(probability, grown.numpy(), atol=1e-4)


def test_class_numbers_are_not_interpolated() -> None:
    numbers = np.array([[0, 4], [7, -1]], np.int32)
    classes, probability = resized_classes(numbers, 6, 8)
    assert probability is None
    np.testing.assert_array_equal(classes, np.kron(numbers, np.ones((3, 4), np.int32)))


def flood_fill(classes: np.ndarray) -> set[frozenset]:
    """Pieces of pixels of one class that touch at sides or corners, one pixel after the other."""
    left = {tuple(at) for at in np.argwhere(classes >= 0)}
    pieces = set()
    while left:
        piece, todo = set(), [left.pop()]
        while todo:
            row, column = todo.pop()
            piece.add((row, column))
            near = {(row + i, column + j) for i in (-1, 0, 1) for j in (-1, 0, 1)} & left
            same = {at for at in near if classes[at] == classes[row, column]}
            left -= same
            todo += same
        pieces.add(frozenset(piece))
    return pieces


def test_pieces_are_those_of_a_flood_fill() -> None:
    classes = np.random.default_rng(5).integers(-1, 3, (14, 17)).astype(np.int32)
    pieces, numbers = class_pieces(classes, 1)
    assert {frozenset(map(tuple, np.argwhere(piece))) for piece in pieces} == flood_fill(classes)
    for piece, number in zip(pieces, numbers, strict=True):
        assert (classes[piece] == number).all()
    large = [piece for piece in pieces if piece.sum() >= 4]
    np.testing.assert_array_equal(class_pieces(classes, 4)[0], large)
    assert connected_pieces(np.zeros((3, 4), np.bool_), 1) == []


@pytest.mark.parametrize(
    ("shape", "layout"),
    [
        ((1, 5, 24, 32), "first"), ((1, 24, 32, 5), "last"), ((5, 24, 32), "first"), ((24, 32, 5), "last"),
        ((1, 24, 32), "map"), ((24, 32), "map"), ((24, 32, 1), "map"), ((1, 1, 24, 32), "map"),
        ((1, 24, 32, 1), "map"), ((1, 5, 25, 32), "first"), ((None, 5, None, None), "first"),
        ((2, 5, 24, 32), None), ((1, 7, 24, 32), None), ((1, 300, 38), None), ((1, 5, 32, 24), None), ((5,), None),
        ((1, 1, 5, 24, 32), None),
    ],
)  # fmt: skip
def test_how_outputs_hold_classes(shape: tuple, layout: str | None) -> None:
    assert layout_of(shape, 5, (96, 128)) == layout
    assert layout_of((None, None, None), 5, (None, None)) is not None


def test_classes_come_first_wherever_they_stood() -> None:
    logits = np.random.default_rng(0).normal(size=(5, 24, 32)).astype(np.float32)
    for output in (logits, logits[None], logits.transpose(1, 2, 0), logits.transpose(1, 2, 0)[None]):
        np.testing.assert_array_equal(class_scores(output, 5, (96, 128)), logits)
    numbers = logits.argmax(axis=0)
    for output in (numbers, numbers[None], numbers[None, None], numbers[..., None], numbers[None, ..., None]):
        np.testing.assert_array_equal(class_scores(output.astype(np.float32), 5, (96, 128)), numbers)


def test_labels_of_nothing_are_no_class_and_fractions_are_refused() -> None:
    numbers = class_scores(np.array([[[0, 255], [3, 1]]], np.uint8), 4, (2, 2))
    np.testing.assert_array_equal(numbers, [[0, -1], [3, 1]])
    with pytest.raises(ValueError, match="one channel of fractions"):
        class_scores(np.full((1, 1, 4, 5), 0.5, np.float32), 4, (4, 5))
    with pytest.raises(ValueError, match="class -7"):
        class_scores(np.full((1, 4, 5), -7), 4, (4, 5))


@pytest.mark.parametrize(
    ("name", "stuff"),
    [
        *(
            (name, True)
            for name in ("wall", "Floor", "ceiling", "floor;flooring", "road, route", "wall-brick", "walls")
        ),
        *((name, True) for name in ("wall-other-merged", "floor-wood", "sky-other-merged", "wood floor", "dirt track")),
        *((name, False) for name in ("wall-cabinet", "wall clock", "floor lamp", "water bottle", "shower wall", "")),
        *((name, False) for name in ("chair", "cabinet", "rug", "window", "door", "playing card", "wood", "grassy")),
    ],
)
def test_names_of_stuff(name: str, stuff: bool) -> None:
    assert is_stuff_name(name) is stuff
