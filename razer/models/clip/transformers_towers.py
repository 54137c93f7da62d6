"""CLIP, SigLIP and similar models run by the library transformers, from a folder that its save_pretrained writes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError
from transformers import AutoModel, AutoTokenizer
from transformers.utils import logging

from razer.arrays import Float32Array
from razer.errors import BadInput, one_line
from razer.models.clip.image_input import ImageInput
from razer.models.clip.patch_features import aligned_features, has_aligned_features, token_features
from razer.models.runtime.device import Device
from razer.models.runtime.torch_device import torch_device

_DAMAGED = (OSError, ValueError, KeyError, RuntimeError, SafetensorError)


class TransformersTowers:
    """Towers of an AutoModel that has get_image_features and get_text_features; raises BadInput."""

    def __init__(self, folder: Path, device: Device) -> None:
        self._folder = folder
        self._device = torch_device(device)
        self._model = _loaded(folder).eval().to(self._device)
        vision = self._model.config.vision_config
        self.patch: int | None = getattr(vision, "patch_size", None)
        # SigLIP 2 with images of any shape has no size, but a number of patches it was trained with.
        self._flat = not hasattr(vision, "image_size")
        size = round(vision.num_patches**0.5) * vision.patch_size if self._flat else vision.image_size
        self.image_input = ImageInput.beside(folder, size=size)
        self._tokenizer = _tokenizer(folder)
        self._is_siglip = self._model.config.model_type.startswith("siglip")

    @torch.inference_mode()
    def encode_images(self, batch: Float32Array) -> Float32Array:
        """See Towers."""
        return _array(self._model.get_image_features(**self._pixels(batch)).pooler_output)

    @torch.inference_mode()
    def encode_texts(self, texts: Sequence[str]) -> Float32Array:
        """See Towers. SigLIP was trained on lower-case texts, padded to full length, with the padding attended to; the
        others do not attend to padding."""
        longest = min(self._model.config.text_config.max_position_embeddings, self._tokenizer.model_max_length)
        tokens = self._tokenizer(
            [text.lower() for text in texts] if self._is_siglip else list(texts),
            padding="max_length" if self._is_siglip else True,
            truncation=True,
            max_length=longest,
            return_tensors="pt",
        ).to(self._device)
        inputs = {"input_ids": tokens["input_ids"]}
        if not self._is_siglip:
            inputs["attention_mask"] = tokens["attention_mask"]
        return _array(self._model.get_text_features(**inputs).pooler_output)

    @torch.inference_mode()
    def feature_map(self, image: Float32Array, *, aligned: bool) -> Float32Array:
        """See Towers."""
        if self.patch is None or (aligned and not has_aligned_features(self._model)):
            raise BadInput(f"{self._folder} has no such features at each pixel: set embedder option vectors to crops")
        pixels = self._pixels(image[None])
        if not self._flat:
            pixels["interpolate_pos_encoding"] = True
        tokens = aligned_features(self._model, pixels) if aligned else token_features(self._model, pixels)
        rows, columns = (side // self.patch for side in image.shape[1:])
        return _array(tokens).reshape(rows, columns, -1)

    def _pixels(self, batch: Float32Array) -> dict[str, Any]:
        pixels = torch.from_numpy(batch).to(self._device)
        return _flattened(pixels, self.patch) if self._flat and self.patch else {"pixel_values": pixels}


def _loaded(folder: Path) -> Any:
    logging.set_verbosity_error()
    logging.disable_progress_bar()
    # The library fills what is missing or does not fit with random numbers, and says so in a table.
    # Code that a checkpoint brings along is never run, nor is anybody asked whether to.
    choices = {"local_files_only": True, "trust_remote_code": False, "ignore_mismatched_sizes": True}
    try:
        model, info = AutoModel.from_pretrained(folder, dtype=torch.float32, output_loading_info=True, **choices)
    except _DAMAGED as error:
        raise BadInput(f"{folder} cannot be loaded as an image-text model: {one_line(error)}") from error
    if not (hasattr(model, "get_image_features") and hasattr(model, "get_text_features")):
        raise BadInput(f"{folder} is a {model.config.model_type}, which does not bring images and texts together")
    _check_weights(folder, info)
    return model


def _check_weights(folder: Path, info: Mapping[str, Any]) -> None:
    if info["missing_keys"]:
        raise BadInput(f"{folder} lacks weights of the model, among them {min(info['missing_keys'])}")
    if info["mismatched_keys"]:
        name = min(info["mismatched_keys"])[0]
        raise BadInput(f"{folder}: weights are not of the size that config.json says, {name}")


def _tokenizer(folder: Path) -> Any:
    try:
        return AutoTokenizer.from_pretrained(folder, local_files_only=True, trust_remote_code=False)
    except (*_DAMAGED, ImportError) as error:
        raise BadInput(f"the tokenizer of {folder} cannot be loaded: {one_line(error)}") from error


def _flattened(pixels: torch.Tensor, patch: int) -> dict[str, Any]:
    """Images (N, 3, H, W) as rows of patches, each with its pixels in order and the three colours of a pixel beside
    each other."""
    n, channels, height, width = pixels.shape
    rows, columns = height // patch, width // patch
    cells = pixels.reshape(n, channels, rows, patch, columns, patch).permute(0, 2, 4, 3, 5, 1)
    return {
        "pixel_values": cells.reshape(n, rows * columns, -1),
        "pixel_attention_mask": torch.ones(n, rows * columns, dtype=torch.long, device=pixels.device),
        "spatial_shapes": torch.tensor([[rows, columns]] * n, device=pixels.device),
    }


def _array(tensor: torch.Tensor) -> Float32Array:
    return tensor.float().cpu().numpy()
