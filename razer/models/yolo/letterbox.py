"""Letterboxing: an image scaled evenly into a network's input and padded on both sides."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from razer.arrays import Float32Array, Float64Array, Int64Array, Uint8Array

Shape = tuple[int, int]
_GREY = 114  # the padding that YOLO models were trained with


@dataclass(frozen=True)
class Letterbox:
    """Where an image (rows, columns) lies in an input: its size there, and the padding above it and left of it."""

    image: Shape
    input: Shape
    content: Shape
    top: int
    left: int

    @classmethod
    def of(cls, image: Shape, limit: Shape, stride: tuple[int | None, int | None] = (None, None)) -> Letterbox:
        """The largest fit into `limit` (rows, columns); a side with a stride may be smaller, by whole strides."""
        scale = min(limit[0] / image[0], limit[1] / image[1])
        rows, columns = (max(1, min(side, round(own * scale))) for own, side in zip(image, limit, strict=True))
        height = limit[0] if stride[0] is None else -(-rows // stride[0]) * stride[0]
        width = limit[1] if stride[1] is None else -(-columns // stride[1]) * stride[1]
        return cls(image, (height, width), (rows, columns), (height - rows) // 2, (width - columns) // 2)

    def batch(self, rgb: Uint8Array) -> Float32Array:
        """The input (1, 3, rows, columns) with values in [0, 1]."""
        height, width = self.content
        canvas = np.full((*self.input, 3), _GREY, np.uint8)
        inside = canvas[self.top : self.top + height, self.left : self.left + width]
        inside[:] = rgb if self.image == self.content else cv2.resize(rgb, (width, height))
        return np.ascontiguousarray(canvas.transpose(2, 0, 1)[None]) * np.float32(1 / 255)

    def boxes_in_image(self, boxes: Float32Array) -> Int64Array:
        """Boxes (N, 4) x1, y1, x2, y2 of the input as pixel bounds of the image: pixels whose centre is inside."""
        (sy, sx), (rows, columns) = self._scale, self.image
        corners = (boxes - [self.left, self.top, self.left, self.top]) / [sx, sy, sx, sy]
        return np.rint(corners.clip(0, [columns, rows, columns, rows])).astype(np.int64)

    def grid_from_image(self, grid: Shape) -> tuple[Float64Array, Float64Array]:
        """(slope, offset), each (x, y), from pixel positions of the image to positions in a grid (rows, columns)
        that spans the input; whole numbers are centres in both."""
        cells = np.array([grid[1] / self.input[1], grid[0] / self.input[0]])
        scale = np.array(self._scale[::-1])
        return scale * cells, (scale / 2 + [self.left, self.top]) * cells - 0.5

    @property
    def _scale(self) -> tuple[float, float]:
        return self.content[0] / self.image[0], self.content[1] / self.image[1]
