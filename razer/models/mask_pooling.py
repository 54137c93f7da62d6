"""Masked average pooling of a dense feature map (RAZER eq. 12), without upsampling the map."""

from __future__ import annotations

import cv2
import numpy as np

from razer.arrays import BoolArray, Float32Array


def pool_masks(features: Float32Array, masks: BoolArray) -> Float32Array:
    """Mean (N, D) float32 of a feature map (h, w, D) over the pixels of each mask (N, H, W).

    The map covers the image and is no finer than it; each pixel has the features of the cell it lies in, and one
    that straddles cells has theirs by area. A mask without pixels counts as the whole image.
    """
    height, width, depth = features.shape
    shares = coverage(masks, height, width).reshape(len(masks), height * width)
    total = shares.sum(axis=1, keepdims=True)
    shares = np.where(total > 0, shares / np.where(total > 0, total, 1), np.float32(1 / (height * width)))
    return shares @ features.reshape(-1, depth)


def coverage(masks: BoolArray, height: int, width: int) -> Float32Array:
    """Share in [0, 1] of each cell of a grid that masks (N, H, W) cover, (N, height, width) float32."""
    shares = np.empty((len(masks), height, width), np.float32)
    for mask, share in zip(masks, shares, strict=True):
        cv2.resize(mask.astype(np.float32), (width, height), dst=share, interpolation=cv2.INTER_AREA)
    return shares
