"""A text encoder that many maps share: each text is encoded once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from razer.arrays import Float32Array
from razer.query.ranking import NegativePrompts
from razer.query.text_queries import TEMPLATES, TextQueryEncoder

_MOST = 4096


class KnownTexts(TextQueryEncoder):
    """As `TextQueryEncoder`; the vectors of texts are kept."""

    def __init__(
        self, embedder: object, negatives: NegativePrompts | None = None, templates: Sequence[str] = TEMPLATES
    ) -> None:
        """As `TextQueryEncoder` takes them."""
        super().__init__(embedder, negatives, templates)
        self._known: dict[str, Float32Array] = {}

    def vectors(self, texts: Sequence[str]) -> Float32Array:
        """Unit vectors (N, D) of texts; raises BadInput for a text that a table of names does not have."""
        unknown = [text for text in dict.fromkeys(texts) if text not in self._known]
        if unknown or not texts:
            found = super().vectors(unknown)
            if len(self._known) + len(unknown) > _MOST:
                self._known = {text: self._known[text] for text in texts if text in self._known}
            self._known.update(zip(unknown, found, strict=True))
        return np.stack([self._known[text] for text in texts])
