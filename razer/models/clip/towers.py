"""The protocol of two-tower image-text models, whatever library runs them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from razer.arrays import Float32Array
from razer.models.clip.image_input import ImageInput


class Towers(Protocol):
    """Two encoders with one space of D dimensions; vectors are as the model gives them, not of unit length."""

    @property
    def image_input(self) -> ImageInput:
        """The preprocessing of the image tower."""

    @property
    def patch(self) -> int | None:
        """Side in pixels of the cells of a feature map, for images of any size; None where the size is fixed."""

    def encode_images(self, batch: Float32Array) -> Float32Array:
        """Vectors (N, D) of images (N, 3, size, size), prepared as by image_input."""

    def encode_texts(self, texts: Sequence[str]) -> Float32Array:
        """Vectors (N, D) of texts; raises BadInput where there is no text tower."""

    def feature_map(self, image: Float32Array, *, aligned: bool) -> Float32Array:
        """Features (h, w, D) of a prepared image (3, H, W): if aligned, in the space of texts, else the encoder's own
        last tokens. Raises BadInput where the model has none."""
