"""What each mask shows, cut out as a square picture for an image encoder."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.float32]


def mask_crops(
    rgb: NDArray[np.uint8], masks: NDArray[np.bool_], size: int, *, scale: float, background: float, fill: Pixels
) -> Pixels:
    """Pictures (N, size, size, 3) float32 of the square about each mask (N, H, W) of an image (H, W, 3).

    The square's side is `scale` times the longer side of the mask's bounds. What is not the mask shows with a
    share of `background` in [0, 1] over the colour `fill` (3,), and what is not the image is `fill`. A mask without
    pixels counts as the whole image.
    """
    crops = np.empty((len(masks), size, size, 3), np.float32)
    for mask, crop in zip(masks, crops, strict=True):
        shown = mask if mask.any() else np.ones_like(mask)
        square = _square(rgb, shown, scale, background, fill)
        smaller = len(square) > size
        cv2.resize(square, (size, size), dst=crop, interpolation=cv2.INTER_AREA if smaller else cv2.INTER_CUBIC)
    return np.clip(crops, 0, 255, out=crops)


def _square(rgb: NDArray[np.uint8], mask: NDArray[np.bool_], scale: float, background: float, fill: Pixels) -> Pixels:
    x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
    side = max(1, round(scale * max(width, height)))
    left, top = x + (width - side) // 2, y + (height - side) // 2
    rows = slice(max(top, 0), min(top + side, rgb.shape[0]))
    columns = slice(max(left, 0), min(left + side, rgb.shape[1]))
    share = np.where(mask[rows, columns, None], np.float32(1), np.float32(background))
    square = np.empty((side, side, 3), np.float32)
    square[:] = fill
    inside = square[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left]
    inside += share * (rgb[rows, columns] - fill)
    return square
