"""Prompt ensembling (Radford et al. 2021): text vectors of names as the mean over caption templates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from razer.arrays import Float32Array
from razer.models import TextEncoder
from razer.models.name_vectors.name_table import bare_name, median_cosine

# The mean over captions cancels what the captions themselves add.
TEMPLATES = ("a photo of a {}.", "a {} in a room.", "a cropped photo of the {}.")
_UNNAMED = "thing"
_UNRELATED_NAMES = ("person", "chair", "wall", "cup", "car", "tree", "shoe", "lamp", "book", "sky", "dog", "bread")


class PromptEnsemble:
    """Text vectors of any name: the mean of those of captions with the name in them."""

    names: tuple[str, ...] = ()

    def __init__(self, encoder: TextEncoder) -> None:
        self._encoder = encoder

    def embed_texts(self, texts: Sequence[str]) -> Float32Array:
        """Unit vectors (N, D) of names or short descriptions."""
        captions = [template.format(bare_name(text)) for text in texts for template in TEMPLATES]
        mean = self._encoder.embed_texts(captions).reshape(len(texts), len(TEMPLATES), -1).mean(axis=1)
        unit: Float32Array = mean / np.linalg.norm(mean, axis=1, keepdims=True)
        return unit

    def has_name(self, text: str) -> bool:
        """Any text is a name."""
        return True

    def embed_class(self, name: str) -> Float32Array:
        """The unit vector (D,) of a class; without a name that of "thing"."""
        return self.embed_texts([name or _UNNAMED])[0]

    def unrelated_cosine(self) -> float:
        """The median of the cosines between a dozen unrelated names."""
        return median_cosine(self.embed_texts(_UNRELATED_NAMES))
