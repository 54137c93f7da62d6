"""Outputs of semantic models: class maps or logits, with or without a batch, with the classes first or last."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

Layout = Literal["map", "first", "last"]
Shape = tuple[int | None, ...]
Sides = tuple[int | None, int | None]
_ROUNDING = 1.5  # pixels of the input by which the sides of an output may be rounded differently
_NO_CLASS = (-1, 255)  # what label images have where nothing is labelled


def layout_of(shape: Shape, n_classes: int, image: Sides) -> Layout | None:
    """How an output of this shape holds classes of the pixels of an image; None where it cannot. Sides that are None
    are open and may be anything.

    Args:
        shape: (h, w), (1, h, w), (h, w, 1), (C, h, w) or (h, w, C), or one of these in a batch of one.
        n_classes: C; where both ends fit, the classes come first.
        image: rows and columns of the input, to which h and w are in one proportion.
    """
    if len(shape) == 4 and shape[0] in (None, 1):
        shape = shape[1:]
    if len(shape) == 2:
        return "map" if _spans((shape[0], shape[1]), image) else None
    if len(shape) != 3:
        return None
    one, two, three = shape
    ways: tuple[tuple[Layout, int | None, int, Sides], ...] = (
        ("map", one, 1, (two, three)),
        ("map", three, 1, (one, two)),
        ("first", one, n_classes, (two, three)),
        ("last", three, n_classes, (one, two)),
    )
    fitting = [way for way in ways if way[1] in (None, way[2]) and _spans(way[3], image)]
    known_first = sorted(fitting, key=lambda way: way[1] is None)
    return known_first[0][0] if fitting else None


def _spans(sides: Sides, image: Sides) -> bool:
    """Whether a grid may span the image: both scales are the same, but for rounding up."""
    (rows, columns), (height, width) = sides, image
    if rows is None or columns is None or height is None or width is None:
        return True
    return abs(rows / height - columns / width) * min(height, width) <= _ROUNDING


def class_scores(output: NDArray, n_classes: int, image: tuple[int, int]) -> NDArray:
    """Class numbers (h, w) int32, -1 = none, or logits (C, h, w) float32, of an output as `layout_of` takes them;
    raises ValueError saying what is wrong."""
    layout = layout_of(output.shape, n_classes, image)
    if layout is None:
        raise ValueError(f"an output {'x'.join(map(str, output.shape))}")
    array = output[0] if output.ndim == 4 else output
    if layout == "map":
        channel = 0 if array.ndim == 3 and array.shape[0] == 1 else -1
        return _numbers(array if array.ndim == 2 else array.take(0, axis=channel), n_classes)
    return np.ascontiguousarray(array if layout == "first" else array.transpose(2, 0, 1), np.float32)


def _numbers(array: NDArray, n_classes: int) -> NDArray:
    numbers = array.astype(np.int32)
    if not np.array_equal(numbers, array):
        raise ValueError("one channel of fractions")
    numbers[np.isin(numbers, _NO_CLASS) & (numbers != n_classes - 1)] = -1
    if numbers.max(initial=-1) >= n_classes or numbers.min(initial=0) < -1:
        wrong = numbers.max() if numbers.max() >= n_classes else numbers.min()
        raise ValueError(f"class {wrong}")
    return numbers


def expected(n_classes: int) -> str:
    """What outputs are read, in words."""
    return (
        f"a class map 1xHxW of numbers below {n_classes}, or logits 1x{n_classes}xHxW or 1xHxWx{n_classes}, for "
        f"{n_classes} class names"
    )
