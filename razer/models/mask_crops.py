"""Square image crops around masks, with dimmed background, for an image encoder."""

from __future__ import annotations

import cv2
import numpy as np

from razer.arrays import BoolArray, Uint8Array


def mask_crops(
    rgb: Uint8Array, masks: BoolArray, size: int, *, scale: float, background: float, fill: Uint8Array
) -> Uint8Array:
    """Crops (N, size, size, 3) uint8 of the square around each mask. A mask without pixels counts as the whole image.

    Args:
        rgb: (H, W, 3), the image.
        masks: (N, H, W).
        size: side of the crops, pixels.
        scale: side of the square over the longer side of the mask's bounding box.
        background: opacity in [0, 1] of what is outside the mask, over `fill`.
        fill: (3,), the colour outside the image.
    """
    crops = np.empty((len(masks), size, size, 3), np.uint8)
    dimmed = cv2.LUT(rgb, _dimming(background, fill))
    for mask, crop in zip(masks, crops, strict=True):
        region = mask if mask.any() else np.ones_like(mask)
        square = _square(rgb, dimmed, region, scale, fill)
        smaller = len(square) > size
        cv2.resize(square, (size, size), dst=crop, interpolation=cv2.INTER_AREA if smaller else cv2.INTER_CUBIC)
    return crops


def _dimming(background: float, fill: Uint8Array) -> Uint8Array:
    """What each value of each colour becomes outside the mask, (1, 256, 3)."""
    values = np.arange(256)[:, None]
    return np.rint(background * values + (1 - background) * fill).astype(np.uint8)[None]


def _square(rgb: Uint8Array, dimmed: Uint8Array, mask: BoolArray, scale: float, fill: Uint8Array) -> Uint8Array:
    x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
    side = max(1, round(scale * max(width, height)))
    left, top = x + (width - side) // 2, y + (height - side) // 2
    rows = slice(max(top, 0), min(top + side, rgb.shape[0]))
    columns = slice(max(left, 0), min(left + side, rgb.shape[1]))
    square = np.empty((side, side, 3), np.uint8)
    square[:] = fill
    inside = square[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left]
    inside[:] = dimmed[rows, columns]
    cv2.copyTo(rgb[rows, columns], mask[rows, columns].view(np.uint8), dst=inside)
    return square
