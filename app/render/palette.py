"""One colour for each instance id, the same in every output."""

from __future__ import annotations

import numpy as np

from razer.arrays import IntArray, Uint8Array

_GOLDEN_RATIO = 0.6180339887498949
_GREY = 128


def instance_colors(ids: IntArray) -> Uint8Array:
    """Colours (N, 3) of instance ids (N,): neighbouring ids get far apart hues, 0 (no instance) is grey."""
    ids = np.asarray(ids, np.int64)
    hue = 6 * ((ids * _GOLDEN_RATIO) % 1)
    saturation = np.array([0.85, 0.6, 0.95])[ids % 3]
    value = np.array([0.95, 0.85, 0.7])[(ids // 3) % 3]
    ramps = np.clip(np.abs((hue[:, None] + np.array([0.0, 4.0, 2.0])) % 6 - 3) - 1, 0, 1)
    colors = value[:, None] * (1 - saturation[:, None] * (1 - ramps))
    return np.where(ids[:, None] > 0, np.round(255 * colors), _GREY).astype(np.uint8)


def tinted(colors: Uint8Array, ids: IntArray) -> Uint8Array:
    """Colours (N, 3) mixed half and half with those of their instance ids (N,); without an instance as they are."""
    blended = (colors.astype(np.uint16) + instance_colors(ids)) // 2
    return np.where(np.asarray(ids)[:, None] > 0, blended, colors).astype(np.uint8)
