"""What every model of SAM's family can do, whichever library runs it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol

from razer.arrays import Float32Array, Float64Array, Uint8Array
from razer.models.model_view import ModelView

Answers = Iterator[tuple[Float32Array, Float32Array]]


class Promptable(Protocol):
    """A model that looks at an image once and then answers many prompts.

    Answers come in batches: logits (P, M, h, w), positive inside a mask, over the image at any resolution, and the
    quality that the model expects of each mask, (P, M).
    """

    def encode(self, rgb: Uint8Array) -> tuple[Any, ModelView]:
        """The model's own features of an image (H, W, 3), and how it lies in the model's square."""

    def at_points(self, features: Any, view: ModelView, points: Float64Array) -> Answers:
        """What lies at each of N points (N, 2) of the image, x before y, one point a prompt."""

    def in_boxes(self, features: Any, view: ModelView, boxes: Float64Array) -> Answers:
        """What each of N boxes (N, 4) of the image holds: left, top, right, bottom. May raise BadInput if the model
        takes none."""
