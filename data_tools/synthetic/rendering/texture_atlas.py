"""Texture atlas of the procedural textures with mipmaps, sampled without moire."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from data_tools.synthetic.rendering.procedural_textures import PAINTERS, SIZE
from razer.arrays import Float32Array, Uint8Array

LEVELS = 6


@dataclass(frozen=True, slots=True)
class Atlas:
    """All textures with their mipmaps in one grey image: texture t at level l is a square of SIZE >> l pixels
    whose first pixel is (left[t], top[l]), with one wrapped pixel around it."""

    image: Uint8Array
    left: dict[str, int]
    top: Float32Array


@lru_cache(maxsize=4)
def paint_atlas(seed: int) -> Atlas:
    """Paint all textures; the same seed gives the same pixels, painted once."""
    heights = [(SIZE >> level) + 2 for level in range(LEVELS)]
    top = np.concatenate([[0], np.cumsum(heights)[:-1]]) + 1
    image = np.zeros((sum(heights), len(PAINTERS) * (SIZE + 2)), np.uint8)
    for number, paint in enumerate(PAINTERS.values()):
        texture = np.clip(paint(np.random.default_rng([seed, number])), 0, 1) * 255
        left = number * (SIZE + 2)
        for level in range(LEVELS):
            size = SIZE >> level
            smaller = cv2.resize(texture, (size, size), interpolation=cv2.INTER_AREA)
            padded = np.pad(smaller, 1, mode="wrap")
            image[top[level] - 1 : top[level] + size + 1, left : left + size + 2] = np.rint(padded)
    return Atlas(image, {name: n * (SIZE + 2) + 1 for n, name in enumerate(PAINTERS)}, top.astype(np.float32))
