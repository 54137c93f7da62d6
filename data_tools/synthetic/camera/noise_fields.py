"""Precomputed noise fields read through random windows: a new window a frame costs hardly any random numbers."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from razer.arrays import Float32Array, Int16Array

Size = tuple[int, ...]
"""(height, width) or (height, width, channels)."""

_PLAY = 256  # windows differ by up to this many pixels in each direction


def normal(size: Size, rng: np.random.Generator) -> Float32Array:
    """Independent normal numbers of unit deviation; the caller must not write to them."""
    return _window(_normal_field(size), size, rng)


def uniform(size: Size, rng: np.random.Generator) -> Float32Array:
    """Independent numbers evenly spread over [0, 1); the caller must not write to them."""
    return _window(_uniform_field(size), size, rng)


def whole_normal(size: Size, sigma: float, rng: np.random.Generator) -> Int16Array:
    """Independent normal numbers of the given deviation, rounded; the caller must not write to them."""
    return _window(_whole_field(size, sigma), size, rng)


def _window(field: NDArray, size: Size, rng: np.random.Generator) -> NDArray:
    row, column = rng.integers(_PLAY + 1, size=2)
    return field[row : row + size[0], column : column + size[1]]


def _roomy(size: Size) -> Size:
    return size[0] + _PLAY, size[1] + _PLAY, *size[2:]


# One seed for all: which window is looked through is what differs between frames and recordings.
@lru_cache(maxsize=4)
def _normal_field(size: Size) -> Float32Array:
    return np.random.default_rng(0).standard_normal(_roomy(size), np.float32)


@lru_cache(maxsize=4)
def _uniform_field(size: Size) -> Float32Array:
    return np.random.default_rng(1).random(_roomy(size), np.float32)


@lru_cache(maxsize=8)
def _whole_field(size: Size, sigma: float) -> Int16Array:
    exact = np.random.default_rng(len(size)).standard_normal(_roomy(size), np.float32) * np.float32(sigma)
    return np.rint(exact).astype(np.int16)
