"""Benchmark of mask description beside the image encoder: pooling a feature map, and cutting crops."""

from __future__ import annotations

import numpy as np

from app.benchmark.repeated_timing import median_ms
from razer.arrays import BoolArray
from razer.models.mask_crops import mask_crops
from razer.models.mask_pooling import pool_masks

_MASKS, _HEIGHT, _WIDTH = 30, 480, 640
_FEATURES = (60, 80, 512)
_CROP = 224


def measure_describing() -> dict[str, float]:
    """Milliseconds, median, for 30 masks of an image of 640x480: the mean of 60x80x512 features over each, and
    224-pixel crops of each."""
    rng = np.random.default_rng(0)
    masks = _ellipses(rng)
    features = rng.standard_normal(_FEATURES).astype(np.float32)
    rgb = rng.integers(0, 256, (_HEIGHT, _WIDTH, 3), dtype=np.uint8)
    grey = np.full(3, 127, np.uint8)
    return {
        "masks": _MASKS,
        "pooling_ms": round(median_ms(lambda: pool_masks(features, masks)), 1),
        "crops_ms": round(median_ms(lambda: mask_crops(rgb, masks, _CROP, scale=1.2, background=0.5, fill=grey)), 1),
    }


def _ellipses(rng: np.random.Generator) -> BoolArray:
    """Masks of 30 to 240 pixels across."""
    y, x = np.mgrid[:_HEIGHT, :_WIDTH]
    radius = rng.uniform(15, 120, (2, _MASKS, 1, 1))
    centre = rng.uniform(0, 1, (2, _MASKS, 1, 1)) * np.array([_HEIGHT, _WIDTH]).reshape(2, 1, 1, 1)
    return ((y - centre[0]) / radius[0]) ** 2 + ((x - centre[1]) / radius[1]) ** 2 < 1
