"""Noise of a structured-light depth camera and of a colour sensor."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

_EDGE_JUMP_M = 0.05


def noisy_depth(depth: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Depth in metres with axial noise that grows with the square of the distance (Nguyen, Izadi, Lovell 2012),
    readings lost at random along depth edges, and whole millimetres."""
    sigma = 0.0012 + 0.0019 * (depth - 0.4) ** 2
    noisy = depth + sigma * rng.standard_normal(depth.shape, np.float32)
    span = cv2.morphologyEx(depth, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
    lost = (depth <= 0) | ((span > _EDGE_JUMP_M) & (rng.random(depth.shape, np.float32) < 0.5))
    return np.where(lost, 0, np.rint(noisy * 1000) / 1000).astype(np.float32)


def noisy_colour(rgb: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """Colour with independent noise of 2.5 grey levels on every channel."""
    return np.clip(rgb + 2.5 * rng.standard_normal(rgb.shape, np.float32), 0, 255).astype(np.uint8)
