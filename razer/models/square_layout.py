"""Layout of an image in a model's square input: stretched, or scaled evenly and padded."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from razer.arrays import Float32Array, Float64Array, Uint8Array

# ImageNet's mean and standard deviation of colours in [0, 1], with which most models were trained
MEAN, DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)


@dataclass(frozen=True)
class SquareLayout:
    """An image of `width` and `height` pixels fills `columns` and `rows` of a square of `side` pixels, from its top
    left corner."""

    side: int
    width: int
    height: int
    columns: int
    rows: int

    @classmethod
    def of(cls, height: int, width: int, side: int, stretched: bool) -> SquareLayout:
        """The layout of an image in a model's input.

        Args:
            height: of the image, pixels.
            width: of the image, pixels.
            side: of the square, pixels.
            stretched: whether it fills the whole square, as for SAM 2, or keeps its shape, as for SAM.
        """
        if stretched:
            return cls(side, width, height, side, side)
        scale = side / max(height, width)
        return cls(side, width, height, int(width * scale + 0.5), int(height * scale + 0.5))

    def resized(self, rgb: Uint8Array) -> Float32Array:
        """The image (H, W, 3) at the size it has in the square, colours in [0, 255]."""
        return cv2.resize(rgb, (self.columns, self.rows), interpolation=cv2.INTER_LINEAR).astype(np.float32)

    def square(
        self, rgb: Uint8Array, mean: tuple[float, ...] = MEAN, deviation: tuple[float, ...] = DEVIATION
    ) -> Float32Array:
        """The whole square with the image (H, W, 3) normalised and zeros around it, (1, 3, side, side)."""
        scaled = (self.resized(rgb) / 255 - np.array(mean, np.float32)) / np.array(deviation, np.float32)
        square = np.zeros((1, 3, self.side, self.side), np.float32)
        square[0, :, : self.rows, : self.columns] = scaled.transpose(2, 0, 1)
        return square

    def coordinates(self, points: Float64Array) -> Float32Array:
        """Image coordinates (..., 2), x before y, in the square."""
        return (points * (self.columns / self.width, self.rows / self.height)).astype(np.float32)

    def filled(self, logits: Float32Array) -> Float32Array:
        """The part of maps (..., h, w) over the square that the image fills."""
        height, width = logits.shape[-2:]
        return logits[..., : round(height * self.rows / self.side), : round(width * self.columns / self.side)]
