"""Procedural grey textures of SIZE x SIZE pixels in 0..1; all but pictures, screens and notes tile."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.arrays import Float32Array

SIZE = 512


def _noise(rng: np.random.Generator, falloff: float, stretch: float = 1.0) -> Float32Array:
    """Tileable noise in 0..1 whose amplitude falls with frequency^falloff; stretch > 1 draws it out along u."""
    fy, fx = np.meshgrid(np.fft.fftfreq(SIZE), np.fft.rfftfreq(SIZE), indexing="ij")
    radius = np.hypot(fx * stretch, fy)
    radius[0, 0] = np.inf
    spectrum = np.fft.rfft2(rng.standard_normal((SIZE, SIZE))) * radius**-falloff
    return _stretched(np.fft.irfft2(spectrum, (SIZE, SIZE)))


def _stretched(image: NDArray) -> Float32Array:
    low, high = np.percentile(image, [1, 99])
    return np.clip((image - low) / (high - low), 0, 1).astype(np.float32)


def _blobs(rng: np.random.Generator, image: Float32Array, count: int, min_px: float, max_px: float) -> Float32Array:
    """Draw random quadrilaterals, least..most pixels across, that wrap round the borders."""
    canvas = np.ascontiguousarray(image)
    for _ in range(count):
        angles = np.sort(rng.uniform(0, 2 * np.pi, 4))
        radius = rng.uniform(min_px, max_px) / 2
        shape = rng.uniform(0, SIZE, 2) + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        grey = float(rng.uniform(0, 1))
        for shift in np.array([(x, y) for x in (-SIZE, 0, SIZE) for y in (-SIZE, 0, SIZE)]):
            cv2.fillConvexPoly(canvas, np.rint(shape + shift).astype(np.int32), grey)
    return canvas


def _plaster(rng: np.random.Generator) -> Float32Array:
    flakes = _blobs(rng, np.full((SIZE, SIZE), 0.6, np.float32), 350, 8, 28)
    return 0.35 * _noise(rng, 1.2) + 0.65 * _blobs(rng, flakes, 2500, 4, 9)


def _paint(rng: np.random.Generator) -> Float32Array:
    """A painted wall: the grain of a roller, and slow unevenness."""
    return _stretched(0.6 * _noise(rng, 0.5) + 0.4 * _noise(rng, 1.8))


def _terrazzo(rng: np.random.Generator) -> Float32Array:
    return 0.3 * _noise(rng, 0.9) + 0.7 * _blobs(rng, np.full((SIZE, SIZE), 0.5, np.float32), 900, 5, 22)


def _planks(rng: np.random.Generator) -> Float32Array:
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


def _wood(rng: np.random.Generator) -> Float32Array:
    return 0.7 * _noise(rng, 1.3, stretch=8) + 0.3 * _noise(rng, 0.8, stretch=3)


def _fabric(rng: np.random.Generator) -> Float32Array:
    rows, columns = np.mgrid[:SIZE, :SIZE] // 8
    weave = ((rows + columns) % 2).astype(np.float32)
    return 0.25 * weave + 0.4 * _noise(rng, 0.6) + 0.35 * _noise(rng, 1.5)


def _cloth(rng: np.random.Generator) -> Float32Array:
    """Fine weave with a faint mottle, as upholstery has it."""
    rows, columns = np.mgrid[:SIZE, :SIZE] // 2
    weave = ((rows + columns) % 2).astype(np.float32)
    return _stretched(0.3 * weave + 0.6 * _noise(rng, 0.3) + 0.25 * _noise(rng, 1.3))


def _bricks(rng: np.random.Generator) -> Float32Array:
    image = 0.4 * _noise(rng, 1.0)
    for row in range(16):
        for column in range(8):
            left = column * 64 + 32 * (row % 2)
            columns = np.arange(left + 2, left + 62) % SIZE
            image[row * 32 + 2 : row * 32 + 30, columns] += 0.25 + 0.35 * rng.uniform()
    return image


def _shapes(rng: np.random.Generator) -> Float32Array:
    return _blobs(rng, np.full((SIZE, SIZE), 0.5, np.float32), 220, 20, 120)


def _screen(rng: np.random.Generator) -> Float32Array:
    """Windows with lines of text."""
    image = 0.15 + 0.15 * _noise(rng, 2.0)
    for _ in range(14):
        x, y = rng.integers(0, SIZE - 150, 2)
        w, h = rng.integers(80, 150, 2)
        image[y : y + h, x : x + w] = rng.uniform(0.6, 1.0)
        for line in range(y + 8, y + h - 8, 12):
            image[line : line + 5, x + 8 : x + 8 + rng.integers(20, w - 10)] = 0.2
    return image


def _smooth(rng: np.random.Generator) -> Float32Array:
    """Almost even: paint, plastic, metal."""
    return 0.8 * _noise(rng, 2.0) + 0.2 * _noise(rng, 0.3)


def _clouds(rng: np.random.Generator) -> Float32Array:
    return _noise(rng, 2.2)


def _marble(rng: np.random.Generator) -> Float32Array:
    """Dark veins where slow noise crosses its middle."""
    veins = np.abs(_noise(rng, 1.6) - 0.5) * 2
    return 0.75 * np.sqrt(veins) + 0.25 * _noise(rng, 1.2)


def _spines(rng: np.random.Generator) -> Float32Array:
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


def _cover(rng: np.random.Generator) -> Float32Array:
    """The front of a book: a large picture, over it a title in capital letters, a name below."""
    image = 0.5 * _noise(rng, 1.9)
    image[190:430, 40:472] = _landscape(rng)[::2, :432][:240]
    for y, high, count in ((56, 44, 8), (118, 44, 6), (452, 18, 14)):
        pitch = min(48, 420 // count) if high > 20 else 22
        left = (SIZE - count * pitch) // 2
        for letter in range(count):
            x, bar = left + letter * pitch, max(3, high // 5)
            image[y : y + high, x : x + bar] = 0.97
            for level in rng.choice([0, high // 2 - bar // 2, high - bar], 2, replace=False):
                image[y + level : y + level + bar, x : x + pitch - 2 * bar] = 0.97
    return image.astype(np.float32)


def _desktop(rng: np.random.Generator) -> Float32Array:
    """A lit desktop: a picture behind two white windows with text, and a bar below."""
    image = 0.25 + 0.35 * _noise(rng, 2.0)
    for x, y, w, h in ((40, 50, 250, 300), (250, 130, 230, 270)):
        image[y : y + h, x : x + w] = 0.97
        image[y : y + 22, x : x + w] = 0.7
        for line in range(y + 40, y + h - 16, 16):
            image[line : line + 6, x + 16 : x + 16 + int(rng.integers(w // 3, w - 32))] = 0.45
    image[482:] = 0.12
    image[490:504, 12:200:24] = 0.8
    return image


def _exit(rng: np.random.Generator) -> Float32Array:
    """An arrow and an open door, pale on dark."""
    image = 0.08 * _noise(rng, 1.0)
    image[110:400, 330:450] = 0.95
    image[140:400, 360:420] = 0.05
    image[230:282, 60:210] = 0.95
    arrow = np.array([(200, 160), (300, 256), (200, 352)], np.int32)
    return cv2.fillConvexPoly(np.ascontiguousarray(image), arrow, 0.95)


def _keys(rng: np.random.Generator) -> Float32Array:
    """Six rows of sixteen keys with a letter each."""
    image = 0.1 + 0.1 * _noise(rng, 1.0)
    for row in range(6):
        for column in range(16):
            y, x = row * 85 + 6, column * 32 + 3
            image[y : y + 74, x : x + 26] = 0.75
            image[y + 14 : y + 14 + int(rng.integers(8, 30)), x + 6 : x + 6 + int(rng.integers(5, 14))] = 0.1
    return image


def _tiles(rng: np.random.Generator) -> Float32Array:
    """Eight by eight tiles with joints."""
    shades = np.repeat(np.repeat(rng.uniform(0.55, 0.95, (8, 8)), 64, axis=0), 64, axis=1)
    image = shades + 0.2 * (_noise(rng, 1.4) - 0.5)
    for joint in range(-2, 2):
        image[joint % 64 :: 64] = 0.05
        image[:, joint % 64 :: 64] = 0.05
    return image.astype(np.float32)


def _carpet(rng: np.random.Generator) -> Float32Array:
    """An oriental rug: a medallion inside two borders."""
    y, x = np.abs(np.mgrid[:SIZE, :SIZE] - (SIZE - 1) / 2) / (SIZE / 2)
    edge = np.maximum(x, y)
    field = np.where((8 * (x + y) % 1 < 0.4) & (x + y < 0.7), 0.9, 0.35)
    border = np.where((np.floor(x * 24) + np.floor(y * 24)) % 2 == 0, 0.8, 0.2)
    image = np.where(edge > 0.78, border, field)
    image[(np.abs(edge - 0.78) < 0.02) | (edge > 0.96)] = 0.55
    return (0.8 * image + 0.2 * _noise(rng, 0.6)).astype(np.float32)


def _landscape(rng: np.random.Generator) -> Float32Array:
    """A sky with a sun over three ranges of hills, upright with row 0 at the top."""
    image = np.linspace(0.95, 0.75, SIZE, dtype=np.float32)[:, None] + np.zeros(SIZE, np.float32)
    cv2.circle(image, (int(rng.integers(80, 430)), int(rng.integers(60, 160))), int(rng.integers(25, 45)), 1.0, -1)
    rows = np.arange(SIZE)[:, None]
    for level, shade in ((210, 0.55), (300, 0.38), (390, 0.2)):
        angles = np.arange(SIZE) * 2 * np.pi / SIZE
        ridge = level + sum(45 / k * np.cos(k * angles + rng.uniform(0, 6.3)) for k in range(1, 9))
        image = np.where(rows > ridge, shade, image)
    return (image + 0.25 * (_noise(rng, 1.2) - 0.5)).astype(np.float32)


def _stripes(rng: np.random.Generator) -> Float32Array:
    image = 0.25 * _noise(rng, 0.6)
    edges = np.sort(rng.choice(np.arange(1, 32), 15, replace=False)) * 16
    for row, (low, high) in enumerate(zip([0, *edges], [*edges, SIZE], strict=True)):
        image[low:high] += 0.1 + 0.6 * (row % 2)
    return image


def _notes(rng: np.random.Generator) -> Float32Array:
    """Handwriting and drawings on a white board."""
    image = 0.9 + 0.1 * _noise(rng, 1.5)
    for _ in range(9):
        x, y = (int(v) for v in rng.integers(20, 360, 2))
        for line in range(int(rng.integers(1, 5))):
            steps = rng.uniform((5, -7), (14, 7), (int(rng.integers(4, 10)), 2))
            points = np.add(np.cumsum(steps, axis=0), (x, y + 24 * line))
            points[:, 1] = y + 24 * line + steps[:, 1]
            cv2.polylines(image, [np.rint(points).astype(np.int32)], False, 0.1, 3)
    for _ in range(4):
        x, y = (int(v) for v in rng.integers(40, 420, 2))
        cv2.rectangle(image, (x, y), (x + 60, y + 40), 0.2, 3)
    return image


def _print(rng: np.random.Generator) -> Float32Array:
    """A printed page: lines of words between margins."""
    image = 0.93 + 0.07 * _noise(rng, 1.4)
    for top in range(44, SIZE - 50, 15):
        left = 40 + 20 * (rng.uniform() < 0.2)
        end = SIZE - 40 if rng.uniform() < 0.8 else int(rng.integers(150, 400))
        while left < end:
            right = min(left + int(rng.integers(12, 44)), end)
            image[top : top + 6, left:right] = 0.25
            left = right + 7
    return image


def _creases(rng: np.random.Generator) -> Float32Array:
    """Cloth that lies in soft folds: ridges where slow noise crosses its middle, lit from one side."""
    folds = 0.6 * _noise(rng, 2.8, stretch=1.6) + 0.4 * np.abs(_noise(rng, 2.4) - 0.5)
    lit = np.roll(folds, 9, axis=0) + np.roll(folds, 6, axis=1) - 2 * folds
    return _stretched(lit)


PAINTERS: dict[str, Callable[[np.random.Generator], Float32Array]] = {
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
    "keys": _keys,
    "tiles": _tiles,
    "carpet": _carpet,
    "landscape": _landscape,
    "stripes": _stripes,
    "notes": _notes,
    "paint": _paint,
    "cloth": _cloth,
    "cover": _cover,
    "desktop": _desktop,
    "exit": _exit,
    "print": _print,
    "creases": _creases,
}
