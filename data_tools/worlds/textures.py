"""Procedural grey textures that tile, and an atlas of them with mipmaps, sampled without moire."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

SIZE = 512
LEVELS = 6
Image = NDArray[np.float32]


def _noise(rng: np.random.Generator, falloff: float, stretch: float = 1.0) -> Image:
    """Tileable noise in 0..1 whose amplitude falls with frequency^falloff; stretch > 1 draws it out along u."""
    fy, fx = np.meshgrid(np.fft.fftfreq(SIZE), np.fft.rfftfreq(SIZE), indexing="ij")
    radius = np.hypot(fx * stretch, fy)
    radius[0, 0] = np.inf
    spectrum = np.fft.rfft2(rng.standard_normal((SIZE, SIZE))) * radius**-falloff
    return _stretched(np.fft.irfft2(spectrum, (SIZE, SIZE)))


def _stretched(image: NDArray) -> Image:
    low, high = np.percentile(image, [1, 99])
    return np.clip((image - low) / (high - low), 0, 1).astype(np.float32)


def _blobs(rng: np.random.Generator, image: Image, count: int, least: float, most: float) -> Image:
    """Draw random quadrilaterals, least..most pixels across, that wrap round the borders."""
    canvas = np.ascontiguousarray(image)
    for _ in range(count):
        angles = np.sort(rng.uniform(0, 2 * np.pi, 4))
        radius = rng.uniform(least, most) / 2
        shape = rng.uniform(0, SIZE, 2) + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        grey = float(rng.uniform(0, 1))
        for shift in np.array([(x, y) for x in (-SIZE, 0, SIZE) for y in (-SIZE, 0, SIZE)]):
            cv2.fillConvexPoly(canvas, np.rint(shape + shift).astype(np.int32), grey)
    return canvas


def _plaster(rng: np.random.Generator) -> Image:
    flakes = _blobs(rng, np.full((SIZE, SIZE), 0.6, np.float32), 350, 8, 28)
    return 0.35 * _noise(rng, 1.2) + 0.65 * _blobs(rng, flakes, 2500, 4, 9)


def _terrazzo(rng: np.random.Generator) -> Image:
    return 0.3 * _noise(rng, 0.9) + 0.7 * _blobs(rng, np.full((SIZE, SIZE), 0.5, np.float32), 900, 5, 22)


def _planks(rng: np.random.Generator) -> Image:
    """Rows of boards of random length and brightness, with grain along u."""
    image = 0.5 * _noise(rng, 1.3, stretch=8)
    for top in range(0, SIZE, 32):
        cuts = np.sort(rng.choice(np.arange(8, SIZE, 24), 5, replace=False))
        for start, end in zip(cuts, np.roll(cuts, -1), strict=True):
            columns = np.arange(start, end if end > start else end + SIZE) % SIZE
            image[top : top + 32, columns] += 0.5 * rng.uniform(0, 1)
            image[top : top + 32, start] = 0.0
        image[top] = 0.0
    return image


def _wood(rng: np.random.Generator) -> Image:
    return 0.7 * _noise(rng, 1.3, stretch=8) + 0.3 * _noise(rng, 0.8, stretch=3)


def _fabric(rng: np.random.Generator) -> Image:
    rows, columns = np.mgrid[:SIZE, :SIZE] // 8
    weave = ((rows + columns) % 2).astype(np.float32)
    return 0.25 * weave + 0.4 * _noise(rng, 0.6) + 0.35 * _noise(rng, 1.5)


def _bricks(rng: np.random.Generator) -> Image:
    image = 0.4 * _noise(rng, 1.0)
    for row in range(16):
        for column in range(8):
            left = column * 64 + 32 * (row % 2)
            columns = np.arange(left + 2, left + 62) % SIZE
            image[row * 32 + 2 : row * 32 + 30, columns] += 0.25 + 0.35 * rng.uniform()
    return image


def _shapes(rng: np.random.Generator) -> Image:
    return _blobs(rng, np.full((SIZE, SIZE), 0.5, np.float32), 220, 20, 120)


def _screen(rng: np.random.Generator) -> Image:
    """Windows with lines of text."""
    image = 0.15 + 0.15 * _noise(rng, 2.0)
    for _ in range(14):
        x, y = rng.integers(0, SIZE - 150, 2)
        w, h = rng.integers(80, 150, 2)
        image[y : y + h, x : x + w] = rng.uniform(0.6, 1.0)
        for line in range(y + 8, y + h - 8, 12):
            image[line : line + 5, x + 8 : x + 8 + rng.integers(20, w - 10)] = 0.2
    return image


def _smooth(rng: np.random.Generator) -> Image:
    """Almost even: paint, plastic, metal."""
    return 0.8 * _noise(rng, 2.0) + 0.2 * _noise(rng, 0.3)


def _clouds(rng: np.random.Generator) -> Image:
    return _noise(rng, 2.2)


def _marble(rng: np.random.Generator) -> Image:
    """Dark veins where slow noise crosses its middle."""
    veins = np.abs(_noise(rng, 1.6) - 0.5) * 2
    return 0.75 * np.sqrt(veins) + 0.25 * _noise(rng, 1.2)


def _spines(rng: np.random.Generator) -> Image:
    """A row of book backs with titles, drawn along u; v runs up the spine."""
    image = 0.1 * _noise(rng, 0.8)
    left = 0
    while left < SIZE:
        right = min(left + int(rng.integers(16, 40)), SIZE)
        image[:, left:right] += rng.uniform(0.1, 0.9)
        image[:, left] = 0
        grey = float(rng.uniform(0, 1))
        for v in (40, 60, 200, 216, 400):
            image[v : v + int(rng.integers(4, 60)), left + 4 : right - 4] = grey
        left = right
    return image


PAINTERS: dict[str, Callable[[np.random.Generator], Image]] = {
    "plaster": _plaster,
    "terrazzo": _terrazzo,
    "planks": _planks,
    "wood": _wood,
    "fabric": _fabric,
    "bricks": _bricks,
    "shapes": _shapes,
    "screen": _screen,
    "smooth": _smooth,
    "clouds": _clouds,
    "marble": _marble,
    "spines": _spines,
}


@dataclass(frozen=True, slots=True)
class Atlas:
    """All textures with their mipmaps in one grey image: texture t at level l is a square of SIZE >> l pixels
    whose first pixel is (left[t], top[l]), with one wrapped pixel around it."""

    image: NDArray[np.uint8]
    left: dict[str, int]
    top: NDArray[np.float32]


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
