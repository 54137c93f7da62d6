"""Colour edges along lines across the image: how strongly grey changes in the direction of a normal."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from razer.arrays import Float32Array, Float64Array, Uint8Array

_BLUR_PX = 1.0
_STRONG = 0.9  # quantile of the gradient at which an edge counts half


@dataclass(frozen=True)
class ColorEdges:
    """Gradient (H, W) of a grey image by x and y, and the strength at which an edge counts half."""

    by_x: Float32Array
    by_y: Float32Array
    half: float

    @classmethod
    def of(cls, rgb: Uint8Array) -> ColorEdges:
        """The edges of a colour image (H, W, 3)."""
        grey = cv2.GaussianBlur(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY).astype(np.float32), None, _BLUR_PX)
        by_x, by_y = (cv2.Sobel(grey, cv2.CV_32F, dx, 1 - dx, scale=1 / 8).astype(np.float32) for dx in (1, 0))
        half = float(np.quantile(np.hypot(by_x[::2, ::2], by_y[::2, ::2]), _STRONG))
        return cls(by_x, by_y, max(half, 1e-3))

    def is_inside(self, pixels: Float64Array) -> np.ndarray:
        """Which pixels (N, 2) lie within the image."""
        height, width = self.by_x.shape
        return np.asarray(((pixels > 0) & (pixels < (width - 1, height - 1))).all(axis=1))

    def profiles(self, pixels: Float64Array, normals: Float64Array, offsets_px: Float64Array) -> Float32Array:
        """Strength (N, K), 0 to 1, at pixels (N, 2) moved along their normals (N, 2) by K offsets; 0 outside."""
        if not len(pixels):  # which OpenCV cannot remap
            return np.zeros((0, len(offsets_px)), np.float32)
        places = (pixels[:, None] + offsets_px[None, :, None] * normals[:, None]).astype(np.float32)
        x, y = places[..., 0], places[..., 1]
        change = [cv2.remap(part, x, y, cv2.INTER_LINEAR) for part in (self.by_x, self.by_y)]
        strength = np.abs(change[0] * normals[:, None, 0] + change[1] * normals[:, None, 1])
        return (strength / (strength + self.half)).astype(np.float32)
