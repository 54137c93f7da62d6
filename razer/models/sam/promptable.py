"""The protocol of promptable segmentation models, whichever library runs them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol

from razer.arrays import Float32Array, Float64Array, Uint8Array
from razer.models.square_layout import SquareLayout

MaskBatches = Iterator[tuple[Float32Array, Float32Array]]


class Promptable(Protocol):
    """A model that encodes an image once and then segments it for many prompts.

    Masks come in batches: logits (P, M, h, w), positive inside a mask, over the image at any resolution, and the
    IoU that the model predicts for each mask, (P, M).
    """

    def encode(self, rgb: Uint8Array) -> tuple[Any, SquareLayout]:
        """The model's own features of an image (H, W, 3), and its layout in the model's square."""

    def at_points(self, features: Any, layout: SquareLayout, points: Float64Array) -> MaskBatches:
        """The masks at each of N points (N, 2) of the image, x before y, one point a prompt."""

    def in_boxes(self, features: Any, layout: SquareLayout, boxes: Float64Array) -> MaskBatches:
        """The masks in each of N boxes (N, 4) of the image: left, top, right, bottom. May raise BadInput if the model
        takes none."""
