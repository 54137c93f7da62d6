"""Prototype masks (YOLACT, Bolya et al. 2019): each mask is a weighted sum of a few coarse prototypes."""

from __future__ import annotations

import cv2
import numpy as np

from razer.arrays import BoolArray, Float32Array
from razer.models.yolo.letterbox import Letterbox

_FLAGS = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP


def prototype_masks(
    coefficients: Float32Array, prototypes: Float32Array, boxes: Float32Array, letterbox: Letterbox
) -> BoolArray:
    """Masks (N, H, W) at the size of the image; the sums are interpolated before they are compared with zero.

    Args:
        coefficients: (N, M), weights of the prototypes.
        prototypes: (M, h, w), spanning the input.
        boxes: (N, 4), x1, y1, x2, y2 in pixels of the input; outside its box a mask is false.
        letterbox: how the image lies in the input.
    """
    grid = prototypes.shape[1:]
    sums = (coefficients @ prototypes.reshape(len(prototypes), -1)).reshape(-1, *grid)
    slope, offset = letterbox.grid_from_image((grid[0], grid[1]))
    masks = np.zeros((len(coefficients), *letterbox.image), np.bool_)
    for mask, values, (x1, y1, x2, y2) in zip(masks, sums, letterbox.boxes_in_image(boxes).tolist(), strict=True):
        if x1 < x2 and y1 < y2:
            start = slope * [x1, y1] + offset
            matrix = np.column_stack([np.diag(slope), start])
            inside = cv2.warpAffine(values, matrix, (x2 - x1, y2 - y1), flags=_FLAGS, borderMode=cv2.BORDER_REPLICATE)
            np.greater(inside, 0, out=mask[y1:y2, x1:x2])
    return masks
