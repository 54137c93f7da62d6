"""CLIP and similar models (MobileCLIP, PE, EVA, ...) run by the library open_clip."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

import open_clip
import torch
from safetensors import SafetensorError

from razer.arrays import Float32Array
from razer.errors import BadInput, one_line
from razer.models.clip.image_input import ImageInput
from razer.models.clip.open_clip_config import check_open_clip_config
from razer.models.clip.open_clip_training import model_arguments
from razer.models.runtime.device import Device
from razer.models.runtime.torch_device import torch_device

_DAMAGED = (OSError, ValueError, KeyError, RuntimeError, EOFError, UnpicklingError, SafetensorError)


class OpenClipTowers:
    """Towers from a folder with open_clip_config.json, or from a file of weights of a named architecture (see
    model_arguments); raises BadInput."""

    patch: int | None = None

    def __init__(self, weights: Path, architecture: str | None, device: Device) -> None:
        self._weights = weights
        self._device = torch_device(device)
        model, self._tokenizer = _loaded(weights, architecture)
        self._model = model.eval().to(self._device)
        config = open_clip.get_model_preprocess_cfg(model)
        size = config["size"]
        self.image_input = ImageInput(
            size if isinstance(size, int) else size[0], tuple(config["mean"]), tuple(config["std"])
        )

    @torch.inference_mode()
    def encode_images(self, batch: Float32Array) -> Float32Array:
        """See Towers."""
        return self._model.encode_image(torch.from_numpy(batch).to(self._device)).float().cpu().numpy()

    @torch.inference_mode()
    def encode_texts(self, texts: Sequence[str]) -> Float32Array:
        """See Towers."""
        return self._model.encode_text(self._tokenizer(list(texts)).to(self._device)).float().cpu().numpy()

    def feature_map(self, image: Float32Array, *, aligned: bool) -> Float32Array:
        """Raises BadInput: open_clip's encoders have no common structure."""
        raise BadInput(f"{self._weights}: features at each pixel need a model of transformers; set vectors to crops")


def _loaded(weights: Path, architecture: str | None) -> tuple[Any, Any]:
    try:
        if weights.is_dir():
            check_open_clip_config(weights)
            name = f"local-dir:{weights}"
            return open_clip.create_model(name, require_pretrained=True), open_clip.get_tokenizer(name)
        choices = model_arguments(architecture or "")
        model = open_clip.create_model(**choices, pretrained=str(weights))
        return model, open_clip.get_tokenizer(choices["model_name"])
    except _DAMAGED as error:
        if isinstance(error, BadInput):
            raise
        raise BadInput(f"{weights} cannot be loaded by open_clip: {one_line(error)}") from error
