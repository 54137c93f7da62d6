"""Semantic segmentation: connected pieces of each class as masks, stuff flagged."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import numpy as np

from razer.arrays import BoolArray, Float32Array, Int32Array
from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models.runtime.device import Device
from razer.models.semantic.class_pieces import class_pieces, resized_classes
from razer.models.semantic.image_input import Colours
from razer.models.semantic.networks import open_network
from razer.models.stuff_names import listed_names, stuff_classes

REFERENCE_PIXELS = 640 * 480
NO_CLASS = ("other", "others", "background", "void", "unlabeled", "unlabelled", "unknown", "ignore", "nothing")


class SemanticSegmenter:
    """Any model that gives a class for each pixel, by an ONNX file or a checkpoint of the `transformers` library.

    Args:
        weights: an ONNX file, a folder with model.onnx, a checkpoint's folder, or a name of the catalogue or the hub.
        names: a file with the class names; None = those of the model's metadata or configuration.
        stuff: names of the classes that are stuff, instead of those that usually are (see stuff_names).
        ignore: names of classes that are none, such as background.
        confidence: least probability of a pixel's class, where the model gives logits. Higher: less is covered, with
            fewer errors.
        score: of each mask, where the model gives a class map, which does not say how sure it is.
        min_pixels: smaller pieces are dropped; pixels at 640x480, scaled with the image. On real frames pieces below
            200 hold less than 1 % of the pixels, and most of them are specks at borders.
        mean: of the colours the model was trained with, for floating-point images; see ImageInput.
        std: their standard deviation.
        size: longest side of the input in pixels, where the model leaves it open. Smaller: faster and coarser.
        device: auto, cpu or cuda.

    Raises:
        BadInput: for impossible options, and a model of another kind.
    """

    tells_instances = False
    looks_at_color_alone = True
    """A piece of a class may be several things that touch."""

    def __init__(
        self,
        weights: str | Path,
        names: str | Path | None = None,
        stuff: str | Collection[str] | None = None,
        ignore: str | Collection[str] = NO_CLASS,
        confidence: float = 0.0,
        score: float = 0.5,
        min_pixels: int = 200,
        mean: Colours | None = None,
        std: Colours | None = None,
        size: int | None = None,
        device: Device = "auto",
    ) -> None:
        if not (0 <= confidence <= 1 and 0 <= score <= 1 and min_pixels >= 1):
            raise BadInput("the semantic segmenter takes confidence and score from 0 to 1, and min_pixels >= 1")
        self.network = open_network(weights, names, mean, std, size, device)
        self.class_names = self.network.class_names
        self.is_stuff = stuff_classes(self.class_names, stuff)
        ignored = {"", *(name.lower() for name in listed_names(ignore))}
        self.is_class = np.array([name.lower() not in ignored for name in self.class_names], np.bool_)
        self.confidence, self.score, self.min_pixels = confidence, score, min_pixels

    def segment(self, frame: Frame) -> Masks:
        """The pieces of each class in one frame, which do not overlap, by class. Raises BadInput for outputs that are
        no classes."""
        height, width = frame.intrinsics.height, frame.intrinsics.width
        classes, probability = resized_classes(self.network(frame.rgb), height, width)
        classes[~self.is_class[classes]] = -1
        if probability is not None:
            classes[probability < self.confidence] = -1
        pieces, numbers = class_pieces(classes, max(1, round(self.min_pixels * classes.size / REFERENCE_PIXELS)))
        names = tuple(self.class_names[number] for number in numbers)
        return Masks(pieces, self._scores(pieces, probability), names, self._stuff(numbers))

    def _scores(self, pieces: BoolArray, probability: Float32Array | None) -> Float32Array:
        """The mean probability (N,) of each piece's pixels."""
        if probability is None:
            return np.full(len(pieces), self.score, np.float32)
        return np.array([probability[piece].mean().clip(0, 1) for piece in pieces], np.float32)

    def _stuff(self, numbers: Int32Array) -> BoolArray:
        stuff: BoolArray = self.is_stuff[numbers]
        return stuff
