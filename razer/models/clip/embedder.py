"""Open-vocabulary mask embeddings by an image-text model such as CLIP or SigLIP (RAZER eq. 12)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, get_args

import cv2
import numpy as np

from razer.arrays import BoolArray, Float32Array, Uint8Array
from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models.clip.library import library_of, open_towers
from razer.models.clip.towers import Towers
from razer.models.hub.model_file import model_file
from razer.models.mask_crops import mask_crops
from razer.models.mask_pooling import pool_masks
from razer.models.runtime.device import Device

Kind = Literal["crops", "dense", "tokens"]


class ClipEmbedder:
    """One vector for each mask, one for each text, in the space of the model.

    The files are checked at once, and loaded on first use, so that the embedder can be sent to another process.

    Args:
        weights: a folder, a file or a hub id (see razer.models.clip.library).
        vectors: "crops" encodes a crop of each mask; "dense" encodes the frame once and pools, over the mask's pixels,
            features aligned with text (MaskCLIP's value path, or a model made for it): faster, and worse for small
            objects; "tokens" pools the encoder's own tokens, which discriminate but are not aligned with text.
        crop_scale: side of a crop over the longer side of the mask. Larger: more context.
        background: opacity in [0, 1] of the rest of a crop. 0 looks unlike any image the model was trained on, 1 does
            not say which object in the crop is meant; HOV-SG too takes about half of each.
        map_scale: shorter side of the frame for "dense" and "tokens", over the input size that the model was trained
            with. Larger: finer features, and time grows at least with the square.
        batch: crops or texts encoded at a time. Larger: faster on a GPU, more memory.
        unrelated_cosine: cosine of images of unrelated objects: 0.55 to 0.85 with CLIP ViT-B/32, 0.72 on average over
            objects of LVIS; until the map has learnt its own. Larger: similar objects are separated in the first
            frames, and so are two sides of one object.
        architecture: open_clip's MODEL or MODEL:TAG where a file holds weights alone.
        device: auto, cpu or cuda.

    Raises:
        BadInput: for impossible options, or where there is no such model.
    """

    looks_at_color_alone = True

    def __init__(
        self,
        weights: str | Path | None = None,
        *,
        vectors: Kind = "crops",
        crop_scale: float = 1.2,
        background: float = 0.5,
        map_scale: float = 2.0,
        batch: int = 32,
        unrelated_cosine: float = 0.5,
        architecture: str | None = None,
        device: Device = "auto",
    ) -> None:
        if weights is None:
            raise BadInput("embedder clip needs a model: set embedder option weights to a folder, a file or a hub id")
        _require(vectors in get_args(Kind), f"vectors is crops, dense or tokens, not '{vectors}'")
        _require(0.5 <= crop_scale <= 5, f"crop_scale {crop_scale} is not in 0.5 to 5")
        _require(0 <= background <= 1, f"background {background} is not in 0 to 1")
        _require(0.5 <= map_scale <= 8, f"map_scale {map_scale} is not in 0.5 to 8")
        _require(batch >= 1, f"batch {batch} is less than 1")
        _require(0 <= unrelated_cosine < 1, f"unrelated_cosine {unrelated_cosine} is not in 0 to 1")
        _require(device in get_args(Device), f"device is auto, cpu or cuda, not '{device}'")
        self.vectors, self.crop_scale, self.background = vectors, crop_scale, background
        self.map_scale, self.batch, self.unrelated_cosine = map_scale, batch, unrelated_cosine
        self.architecture, self.device = architecture, device
        self.weights = model_file(weights)
        self.library = library_of(self.weights, architecture)

    def embed(self, frame: Frame, masks: Masks) -> Float32Array:
        """See Embedder; raises BadInput where the model cannot be loaded or has no vectors of this kind."""
        return self._of_masks(frame.rgb, masks.masks)

    def embed_region(self, rgb: Uint8Array, mask: BoolArray) -> Float32Array:
        """See ImageEncoder; a mask without pixels counts as the whole image."""
        return self._of_masks(rgb, mask[None])[0]

    def embed_texts(self, texts: Sequence[str]) -> Float32Array:
        """See TextEncoder; raises BadInput where vectors are not aligned with text."""
        if self.vectors == "tokens":
            raise BadInput(
                "an image encoder's own tokens cannot be held against text: set embedder option vectors to crops or "
                "dense and map the recording again"
            )
        encode = self._towers.encode_texts
        return _unit(self._in_batches(len(texts), lambda chosen: encode(texts[chosen])))

    def _of_masks(self, rgb: Uint8Array, masks: BoolArray) -> Float32Array:
        if len(masks) == 0:
            return np.zeros((0, 0), np.float32)
        return _unit(self._of_crops(rgb, masks) if self.vectors == "crops" else self._of_features(rgb, masks))

    def _of_crops(self, rgb: Uint8Array, masks: BoolArray) -> Float32Array:
        image_input, encode = self._towers.image_input, self._towers.encode_images

        def encoded(chosen: slice) -> Float32Array:
            style = {"scale": self.crop_scale, "background": self.background}
            crops = mask_crops(rgb, masks[chosen], image_input.size, fill=image_input.neutral, **style)
            return encode(image_input.batch(crops))

        return self._in_batches(len(masks), encoded)

    def _of_features(self, rgb: Uint8Array, masks: BoolArray) -> Float32Array:
        image_input = self._towers.image_input
        height, width = _map_size(rgb.shape[:2], image_input.size, self._towers.patch, self.map_scale)
        shrinks = height < rgb.shape[0]
        resized = cv2.resize(rgb, (width, height), interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_CUBIC)
        image = image_input.batch(resized[None])[0]
        return pool_masks(self._towers.feature_map(image, aligned=self.vectors == "dense"), masks)

    def _in_batches(self, n: int, encode: Callable[[slice], Float32Array]) -> Float32Array:
        parts = [encode(slice(start, start + self.batch)) for start in range(0, n, self.batch)]
        return np.concatenate(parts) if parts else np.zeros((0, 0), np.float32)

    @cached_property
    def _towers(self) -> Towers:
        return open_towers(self.weights, self.library, self.architecture, self.device)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_towers"}


def _map_size(shape: Sequence[int], size: int, patch: int | None, scale: float) -> tuple[int, int]:
    """Height and width in which a frame is encoded, whole patches; where the model takes one size only, that one."""
    if patch is None:
        return size, size
    enlarged = scale * size / min(shape)
    height, width = (patch * max(1, round(side * enlarged / patch)) for side in shape)
    return height, width


def _unit(vectors: Float32Array) -> Float32Array:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise BadInput(f"embedder option {message}")
