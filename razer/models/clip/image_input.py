"""Image preprocessing of an encoder: input size and colour normalisation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from razer.arrays import Float32Array, Uint8Array
from razer.errors import BadInput, one_line
from razer.files import MALFORMED
from razer.models.hub.sidecar_files import find_sidecar, read_json

# Where the libraries write it: transformers before and since processors are one file, and exports of open_clip.
_FILES = ("preprocessor_config.json", "processor_config.json", "preprocess_cfg.json")


@dataclass(frozen=True)
class ImageInput:
    """Square pictures of `size` pixels, colours (c / 255 - mean) / std for each of red, green and blue."""

    size: int
    mean: tuple[float, float, float]
    std: tuple[float, float, float]

    def __post_init__(self) -> None:
        if self.size < 1 or len(self.mean) != 3 or len(self.std) != 3 or min(self.std) <= 0:
            raise BadInput(f"pictures of {self.size} pixels, mean {self.mean}, deviation {self.std}: impossible")

    @property
    def neutral(self) -> Uint8Array:
        """The colour (3,) that the encoder sees as about zero."""
        return np.rint(255 * np.asarray(self.mean)).astype(np.uint8)

    def batch(self, pictures: Uint8Array) -> Float32Array:
        """Pictures (N, H, W, 3) uint8 as the encoder takes them, (N, 3, H, W) float32."""
        mean, std = (255 * np.asarray(values, np.float32) for values in (self.mean, self.std))
        scaled = (pictures - mean) / std
        return np.ascontiguousarray(scaled.transpose(0, 3, 1, 2))

    @classmethod
    def beside(cls, weights: Path, *, size: int | None = None) -> ImageInput:
        """As in the preprocessor file beside the weights; a size that is given goes before. Raises BadInput."""
        file = next(filter(None, (find_sidecar(weights, name) for name in _FILES)), None)
        if file is None:
            raise BadInput(f"{weights} has no {_FILES[0]} beside it, which says how colours are scaled")
        config = read_json(file)
        config = config.get("image_processor", config)
        size = size or _size(config)
        if size is None:
            raise BadInput(f"{file} does not say the size of pictures")
        scaled = config.get("do_normalize", True)
        mean = config.get("image_mean", config.get("mean")) if scaled else (0, 0, 0)
        std = config.get("image_std", config.get("std")) if scaled else (1, 1, 1)
        if mean is None or std is None:
            raise BadInput(f"{file} does not say the mean and deviation of colours: add image_mean and image_std")
        try:
            return cls(size, tuple(mean), tuple(std))
        except MALFORMED as error:
            raise BadInput(f"{file} does not say how pictures are scaled ({one_line(error)}): correct it") from None


def _size(config: Mapping[str, Any]) -> int | None:
    """The crop's size if pictures are cropped, else that they are brought to."""
    keys = ("crop_size", "size") if config.get("do_center_crop", True) else ("size",)
    size = next((config[key] for key in keys if config.get(key)), None)
    if isinstance(size, Mapping):
        size = size.get("height", size.get("shortest_edge"))
    if isinstance(size, list):
        size = size[0]
    return size
