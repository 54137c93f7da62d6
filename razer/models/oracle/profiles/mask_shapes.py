"""Shapes of simulated masks: borders that stray and bleed, prototypes of a quarter of the resolution, blobs."""

from __future__ import annotations

import cv2
import numpy as np

from razer.arrays import BoolArray
from razer.models.oracle.profiles.visible_things import Window, smooth_noise

BORDER_SIGMA_PX = 1.5
BLEEDING, BLEED_PX = 0.1, 4.0
MARGIN_PX = 10  # by which a mask may grow: bleeding and four standard deviations
_KNOT_SPACING_PX = 16  # of the fields that move borders
_PROTOTYPE = 4  # pixels of the image along one of a prototype mask


def grown_window(window: Window, margin_px: int, shape: tuple[int, ...]) -> Window:
    """A window of the image with a margin on each side, inside the image."""
    rows, columns = (
        slice(max(side.start - margin_px, 0), min(side.stop + margin_px, length))
        for side, length in zip(window, shape, strict=True)
    )
    return rows, columns


def strayed(mask: BoolArray, rng: np.random.Generator) -> BoolArray:
    """The mask (h, w) with its border moved by a smooth random distance of 1.5 px standard deviation; one in ten also
    bleeds outwards by up to 4 px. Wherever it may grow it needs a margin of MARGIN_PX."""
    bleed = rng.uniform(0, BLEED_PX) if rng.random() < BLEEDING else 0.0
    moved = BORDER_SIGMA_PX * smooth_noise(mask.shape, _KNOT_SPACING_PX, rng)
    strayed: BoolArray = signed_distance(mask) + moved + bleed > 0
    return strayed


def signed_distance(mask: BoolArray) -> np.ndarray:
    """The distance (h, w) float32 of each pixel from the border of a mask, pixels: positive inside; the border of the
    image is none of the mask's."""
    pixels = mask.astype(np.uint8)
    inside = cv2.distanceTransform(pixels, cv2.DIST_L2, 5)
    outside = cv2.distanceTransform(1 - pixels, cv2.DIST_L2, 5)
    # Half a pixel lies between the first centre inside and the border.
    return inside - outside - np.where(mask, np.float32(0.5), np.float32(-0.5))


def coarse(mask: BoolArray) -> BoolArray:
    """The mask (h, w) as prototypes of a quarter of the resolution give it: averaged, enlarged, and cut at one half."""
    height, width = mask.shape
    small = (max(width // _PROTOTYPE, 1), max(height // _PROTOTYPE, 1))
    prototype = cv2.resize(mask.astype(np.float32), small, interpolation=cv2.INTER_AREA)
    enlarged: BoolArray = cv2.resize(prototype, (width, height), interpolation=cv2.INTER_LINEAR) > 0.5
    return enlarged


def blob(surface: BoolArray, area_px: int, rng: np.random.Generator) -> BoolArray | None:
    """`area_px` pixels of a surface (h, w) round one of them, in a frayed ellipse; None where the surface is smaller.

    Args:
        surface: where the blob may lie.
        area_px: how many pixels it has.
        rng: of its place and shape.
    """
    rows, columns = np.nonzero(surface)
    if len(rows) < area_px:
        return None
    center = rng.integers(len(rows))
    angle, aspect = rng.uniform(0, np.pi), rng.uniform(1, 2.5)
    x, y = columns - columns[center], rows - rows[center]
    along, across = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
    distance = np.hypot(along, across * aspect) * (1 + 0.2 * smooth_noise(surface.shape, 24, rng)[rows, columns])
    nearest = np.argpartition(distance, area_px - 1)[:area_px]
    chosen = np.zeros_like(surface)
    chosen[rows[nearest], columns[nearest]] = True
    return chosen
