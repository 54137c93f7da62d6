"""The image side of SAM: a picture becomes features, once for all prompts."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.frame import BadInput
from razer.models.onnx_graph import OnnxGraph

# ImageNet's mean and standard deviation, of colours in [0, 255]
_MEAN = np.array([123.675, 116.28, 103.53], np.float32)
_DEVIATION = np.array([58.395, 57.12, 57.375], np.float32)
_USUAL_SIDE = 1024
_LEVELS_OF_SAM2 = 3


@dataclass(frozen=True)
class ModelView:
    """How an image lies in the model's square of `side` pixels: its own `width` and `height` in pixels, and the
    columns and rows of the square that it fills."""

    side: int
    width: int
    height: int
    columns: int
    rows: int

    @classmethod
    def of(cls, height: int, width: int, side: int, stretched: bool) -> ModelView:
        """SAM 2 stretches an image over the whole square; SAM keeps its shape and fills up right and below."""
        if stretched:
            return cls(side, width, height, side, side)
        scale = side / max(height, width)
        return cls(side, width, height, int(width * scale + 0.5), int(height * scale + 0.5))

    def coordinates(self, points: NDArray[np.float64]) -> NDArray[np.float32]:
        """Image coordinates (..., 2), x before y, in the square."""
        return (points * (self.columns / self.width, self.rows / self.height)).astype(np.float32)

    def filled(self, logits: NDArray[np.float32]) -> NDArray[np.float32]:
        """The part of maps (..., h, w) over the square that the image fills."""
        height, width = logits.shape[-2:]
        return logits[..., : round(height * self.rows / self.side), : round(width * self.columns / self.side)]


class SamEncoder:
    """An encoder graph of any of the known exports.

    It takes one image, either (1, 3, S, S) normalised, or (H, W, 3) with colours up to 255 and its longer side S,
    which it normalises itself. What gives three maps of features is of the family of SAM 2. Raises BadInput.
    """

    def __init__(self, graph: OnnxGraph) -> None:
        self.graph = graph
        ports = list(graph.inputs.values())
        shape = ports[0].shape if len(ports) == 1 else ()
        self.raw = len(shape) == 3 and shape[2] in (3, None)
        if not self.raw and not (len(shape) == 4 and shape[1] in (3, None)):
            listed = ", ".join(map(str, ports))
            raise BadInput(f"{graph.file} is no SAM encoder: it takes {listed}, not one image of 3 colours")
        self.input = ports[0].name
        self.side = (None if self.raw else shape[2]) or _USUAL_SIDE
        self.stretched = len(graph.outputs) >= _LEVELS_OF_SAM2

    def encode(self, rgb: NDArray[np.uint8]) -> tuple[dict[str, NDArray], ModelView]:
        """The features of an image (H, W, 3) by name, and how it lies in the square."""
        height, width = rgb.shape[:2]
        view = ModelView.of(height, width, self.side, self.stretched)
        resized = cv2.resize(rgb, (view.columns, view.rows), interpolation=cv2.INTER_LINEAR).astype(np.float32)
        if self.raw:
            return self.graph({self.input: resized}), view
        square = np.zeros((1, 3, self.side, self.side), np.float32)
        square[0, :, : view.rows, : view.columns] = ((resized - _MEAN) / _DEVIATION).transpose(2, 0, 1)
        return self.graph({self.input: square}), view
