"""Outputs of semantic models: class maps or logits, with or without a batch, with the classes first or last."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_NO_CLASS = (-1, 255)  # what label images have where nothing is labelled


def may_be_classes(shape: tuple[int | None, ...], n_classes: int) -> bool:
    """Whether an output of this shape, None = open, may be a class map or logits of so many classes."""
    if len(shape) == 4:
        if shape[0] not in (None, 1):
            return False
        shape = shape[1:]
    return len(shape) == 2 or (len(shape) == 3 and any(side in (None, 1, n_classes) for side in (shape[0], shape[2])))


def class_scores(output: NDArray, n_classes: int) -> NDArray:
    """Class numbers (h, w) int32, -1 = none, or logits (C, h, w) float32; raises ValueError saying what is wrong.

    Args:
        output: (h, w), (1, h, w), (h, w, 1), (C, h, w) or (h, w, C), or one of these in a batch of one.
        n_classes: C; where both ends fit, the classes come first.
    """
    if not may_be_classes(output.shape, n_classes):
        raise ValueError(f"an output {'x'.join(map(str, output.shape))}")
    array = output[0] if output.ndim == 4 else output
    if array.ndim == 3 and 1 in (array.shape[0], array.shape[2]):
        array = array[0] if array.shape[0] == 1 else array[..., 0]
    if array.ndim == 2:
        return _numbers(array, n_classes)
    logits = array if array.shape[0] == n_classes else array.transpose(2, 0, 1)
    return np.ascontiguousarray(logits, np.float32)


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
