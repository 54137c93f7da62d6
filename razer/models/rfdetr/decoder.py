"""Decoding of RF-DETR outputs: one class and one mask for each query, without suppression."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from razer.arrays import BoolArray, Float32Array
from razer.frame import Masks


def decode_queries(
    logits: Float32Array,
    masks: Float32Array,
    class_names: Sequence[str],
    image: tuple[int, int],
    confidence: float,
    max_masks: int,
) -> Masks:
    """Masks at the size of the image, best first.

    Args:
        logits: (Q, C), of which each class has its own sigmoid.
        masks: (Q, h, w) logits that span the image; above 0 is the thing.
        class_names: of the C columns, '' for those that are no class.
        image: rows and columns.
        confidence: least probability of a query's best class.
        max_masks: at most so many, the best.
    """
    is_class = np.array([bool(name) for name in class_names], np.bool_)
    scored = np.where(is_class, logits, -np.inf)
    numbers = scored.argmax(axis=1)
    scores = _sigmoid(scored.max(axis=1))
    order = np.argsort(-scores, kind="stable")
    order = order[scores[order] >= confidence]
    pixels = _upsampled(masks[order], image)
    kept = np.flatnonzero(pixels.any(axis=(1, 2)))[:max_masks]
    best = order[kept]
    return Masks(pixels[kept], scores[best], tuple(class_names[number] for number in numbers[best]))


def _sigmoid(logits: Float32Array) -> Float32Array:
    return (1 / (1 + np.exp(-logits.clip(-80, 80)))).astype(np.float32)


def _upsampled(masks: Float32Array, image: tuple[int, int]) -> BoolArray:
    """Logits (N, h, w) interpolated to the image before they are compared with zero."""
    pixels = np.zeros((len(masks), *image), np.bool_)
    for mask, logits in zip(pixels, masks, strict=True):
        np.greater(cv2.resize(logits, image[::-1], interpolation=cv2.INTER_LINEAR), 0, out=mask)
    return pixels
