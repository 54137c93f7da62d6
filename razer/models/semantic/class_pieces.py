"""Connected pieces of a class map, as masks."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.arrays import BoolArray, Float32Array, Int32Array

_NEIGHBOURS = 8  # pixels that touch at a corner are connected


def resized_classes(scores: NDArray, height: int, width: int) -> tuple[Int32Array, Float32Array | None]:
    """The class (H, W) of each pixel of an image, -1 = none, and the probability of it, None where only classes are
    known.

    Logits are interpolated before they are compared; of all classes those compete that are best somewhere.

    Args:
        scores: class numbers (h, w), or logits or probabilities (C, h, w), that span the image.
        height: of the image, pixels.
        width: of the image, pixels.
    """
    if scores.ndim == 2:
        numbers = scores.astype(np.float32)  # exact: classes are far fewer than 2**24
        return cv2.resize(numbers, (width, height), interpolation=cv2.INTER_NEAREST).astype(np.int32), None
    present = np.unique(scores.argmax(axis=0))
    best = np.full((height, width), -np.inf, np.float32)
    classes = np.full((height, width), -1, np.int32)
    for number in present.tolist():
        values = cv2.resize(scores[number], (width, height), interpolation=cv2.INTER_LINEAR)
        is_better = values > best
        classes[is_better], best[is_better] = number, values[is_better]
    return classes, cv2.resize(_best_probability(scores), (width, height), interpolation=cv2.INTER_LINEAR)


def _best_probability(scores: Float32Array) -> Float32Array:
    """The probability (h, w) of the best class, by softmax unless they are probabilities already."""
    if scores.min() >= 0 and np.allclose(scores.sum(axis=0), 1, atol=1e-3):
        return scores.max(axis=0)
    best: Float32Array = 1 / np.exp(scores - scores.max(axis=0)).sum(axis=0)
    return best


def class_pieces(classes: Int32Array, min_pixels: int) -> tuple[BoolArray, Int32Array]:
    """Connected pieces (N, H, W) of at least so many pixels, and the class (N,) of each, from classes (H, W), which are
    none where negative."""
    pieces, numbers = [], []
    for number in np.flatnonzero(np.bincount(classes[classes >= 0])).tolist():
        for piece in connected_pieces(classes == number, min_pixels):
            pieces.append(piece)
            numbers.append(number)
    stack = np.stack(pieces) if pieces else np.zeros((0, *classes.shape), np.bool_)
    return stack, np.array(numbers, np.int32)


def connected_pieces(mask: BoolArray, min_pixels: int) -> list[BoolArray]:
    """The connected pieces of a mask (H, W) that have at least so many pixels."""
    left, top, width, height = cv2.boundingRect(mask.view(np.uint8))
    part = mask[top : top + height, left : left + width]  # most masks are small, and labelling takes the time
    if not part.size:
        return []
    n_labels, labels, stats, _ = cv2.connectedComponentsWithStats(
        np.ascontiguousarray(part).view(np.uint8), connectivity=_NEIGHBOURS
    )
    pieces = []
    for label in range(1, n_labels):
        if stats[label, cv2.CC_STAT_AREA] >= min_pixels:
            piece = np.zeros(mask.shape, np.bool_)
            piece[top : top + height, left : left + width] = labels == label
            pieces.append(piece)
    return pieces
