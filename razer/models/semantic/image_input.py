"""Image input of a semantic model: axes, type, size and normalisation, as its graph and its files say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.arrays import Uint8Array
from razer.errors import BadInput
from razer.files import parse_json
from razer.models.hub.sidecar_files import find_sidecar, read_json
from razer.models.runtime.onnx_graph import OnnxGraph, TensorSpec
from razer.models.square_layout import DEVIATION, MEAN

_FLOATING, _BYTES = ("tensor(float)", "tensor(float16)"), "tensor(uint8)"
_USUAL_SIZE = 640  # longest side, pixels, where a model leaves it open
_STRIDE = 32  # of open sides; encoders halve the image five times
Colours = Sequence[float]


@dataclass(frozen=True)
class ImageInput:
    """The one input of a graph: channels_last for NHWC; rows and columns, None where the graph leaves them open, when
    the longest side has `longest` pixels; mean and deviation of colours in [0, 1], None where bytes are taken."""

    spec: TensorSpec
    channels_last: bool
    rows: int | None
    columns: int | None
    longest: int
    normalisation: tuple[NDArray, NDArray] | None

    @classmethod
    def of(
        cls, graph: OnnxGraph, mean: Colours | None = None, std: Colours | None = None, size: int | None = None
    ) -> ImageInput:
        """From a graph and what its metadata or a preprocessor_config.json beside it say; raises BadInput.

        Args:
            graph: the model.
            mean: of the colours it was trained with, in [0, 1], or in [0, 255] if one is above 1; None = as its files
                say, else ImageNet's.
            std: their standard deviation, likewise.
            size: longest side in pixels, where the model leaves it open.
        """
        spec, channels_last = _only_image(graph)
        sides = spec.shape[-3:-1] if channels_last else spec.shape[-2:]
        if size is not None and (size < 1 or None not in sides):
            raise BadInput(f"option size = {size}: it is for models that leave it open, and {graph.file} takes {spec}")
        if spec.type == _BYTES and (mean is not None or std is not None):
            raise BadInput(f"options mean and std are for floating-point images, and {graph.file} takes bytes, {spec}")
        normalisation = None if spec.type == _BYTES else _normalisation(graph, mean, std)
        return cls(spec, channels_last, sides[0], sides[1], size or _USUAL_SIZE, normalisation)

    def sides(self, rgb: Uint8Array) -> tuple[int, int]:
        """Rows and columns of the input for an image (H, W, 3)."""
        height, width = rgb.shape[:2]
        strides = self.longest / max(height, width) / _STRIDE
        rows, columns = (max(1, round(own * strides)) * _STRIDE for own in (height, width))
        return self.rows or rows, self.columns or columns

    def __call__(self, rgb: Uint8Array) -> NDArray:
        """The input for an image (H, W, 3), which is stretched to the size of the model."""
        rows, columns = self.sides(rgb)
        image: NDArray = rgb if (rows, columns) == rgb.shape[:2] else cv2.resize(rgb, (columns, rows))
        if self.normalisation is not None:
            mean, deviation = self.normalisation
            image = (image.astype(np.float32) / 255 - mean) / deviation
        image = image if self.channels_last else image.transpose(2, 0, 1)
        return image if len(self.spec.shape) == 3 else image[None]


def _only_image(graph: OnnxGraph) -> tuple[TensorSpec, bool]:
    """The input, and whether its channels come last; raises BadInput unless it is one colour image."""
    inputs = list(graph.inputs.values())
    if len(inputs) == 1 and inputs[0].type in (*_FLOATING, _BYTES) and len(inputs[0].shape) in (3, 4):
        channels, rest = inputs[0].shape[-3:], inputs[0].shape[:-3]
        if all(side in (None, 1) for side in rest):
            for axis in (0, 2):
                if channels[axis] == 3:
                    return inputs[0], axis == 2
            if channels[0] is None:
                return inputs[0], False
    taken = ", ".join(f"{spec} {spec.type}" for spec in inputs) or "nothing"
    raise BadInput(f"{graph.file} takes {taken}, expected one colour image 1x3xHxW or 1xHxWx3 of floats or bytes")


def _normalisation(graph: OnnxGraph, mean: Colours | None, std: Colours | None) -> tuple[NDArray, NDArray]:
    stated = _stated(graph)
    mean = _colour("mean", stated.get("mean", MEAN) if mean is None else mean)
    std = _colour("std", stated.get("std", DEVIATION) if std is None else std)
    if min(std) <= 0:
        raise BadInput(f"segmenter option std is three numbers above 0, not {list(std)}")
    largest = 255.0 if max(*mean, *std) > 1 else 1.0
    return np.array(mean, np.float32) / np.float32(largest), np.array(std, np.float32) / np.float32(largest)


def _stated(graph: OnnxGraph) -> Mapping[str, Any]:
    """Mean and std in the metadata, or in the configuration of the image processor beside the file."""
    stated: dict[str, Any] = {key: _literal(graph.metadata[key]) for key in ("mean", "std") if key in graph.metadata}
    if stated or (config := find_sidecar(graph.file, "preprocessor_config.json")) is None:
        return stated
    settings = read_json(config)
    if not settings.get("do_normalize", True):
        return {"mean": (0.0, 0.0, 0.0), "std": (1.0, 1.0, 1.0)}
    return {key: settings[f"image_{key}"] for key in ("mean", "std") if f"image_{key}" in settings}


def _literal(text: str) -> Any:
    try:
        return parse_json(text.strip().replace("(", "[").replace(")", "]"), "metadata")
    except ValueError:
        return text


def _colour(name: str, value: Any) -> tuple[float, float, float]:
    """Three numbers, of one number or of three."""
    parts = [value] * 3 if isinstance(value, int | float) else value
    if isinstance(parts, str):
        parts = parts.split(",")
    try:
        red, green, blue = (float(part) for part in parts)
    except (TypeError, ValueError):
        raise BadInput(f"segmenter option {name} is three numbers, one for each colour, not {value!r}") from None
    return red, green, blue
