"""A detector of fixed classes becomes one that can be asked in words, through the text vectors of its class names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from razer.arrays import Float32Array
from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models import Embedder, TextSide, make_embedder
from razer.models.name_vectors.caption_vectors import PromptedText
from razer.models.name_vectors.name_table import TextTable


class NamesEmbedder:
    """The text vector of each mask's class name, from one of two sources.

    table: a file of names and their text vectors (see TextTable); words it lacks cannot be asked for. embedder,
    embedder_options: an embedder with a text side, a name or an object, which takes any word.

    A mask whose name the table lacks, or that has an empty one, gets a vector of that name's own, like no word of
    the table: the tracker keeps masks called alike together and others apart, and no query finds them by chance. A
    vector between all names would be nearer to most queries than any wrong name is. Raises BadInput.
    """

    def __init__(
        self,
        table: str | Path | None = None,
        embedder: str | Embedder | None = None,
        embedder_options: Mapping[str, Any] | None = None,
    ) -> None:
        if (table is None) == (embedder is None):
            raise BadInput("the names embedder takes either option table, a file of text vectors, or option embedder")
        self._source = TextTable(table) if table else _encoder(embedder or "", embedder_options or {})
        self._seen: dict[str, Float32Array] = {}

    @property
    def known_names(self) -> tuple[str, ...]:
        """The names of the table, synonyms left out; none where any name is known."""
        return self._source.names

    @property
    def takes_any_name(self) -> bool:
        """Whether names go through an encoder, which takes its time and knows all of them."""
        return isinstance(self._source, PromptedText)

    @cached_property
    def unrelated_cosine(self) -> float:
        """The cosine that the vectors of any two names have, in the middle."""
        return self._source.unrelated_cosine()

    def embed_texts(self, texts: Sequence[str]) -> Float32Array:
        """Unit vectors (N, D) of names, no sentences; raises BadInput for a word that the table lacks."""
        return self._source.embed_texts(texts)

    def embed(self, frame: Frame, masks: Masks) -> Float32Array:
        """Unit vectors (N, D) of the masks' class names; raises BadInput for masks of a model that names nothing."""
        if len(masks) and masks.class_names is None:
            raise BadInput(
                "the names embedder needs masks with class names: use a segmenter that names what it finds, such as "
                "yolo, or another embedder"
            )
        vectors = [self._vector(name) for name in masks.class_names or ()]
        return np.stack(vectors) if vectors else np.zeros((0, len(self._vector(""))), np.float32)

    def _vector(self, name: str) -> Float32Array:
        if name not in self._seen:
            self._seen[name] = self._source.embed_class(name)
        return self._seen[name]


def _encoder(chosen: str | Embedder, options: Mapping[str, Any]) -> PromptedText:
    embedder = make_embedder(chosen, options) if isinstance(chosen, str) else chosen
    if not isinstance(embedder, TextSide):
        raise BadInput(f"embedder '{chosen}' has no text side: the names embedder needs one that knows words")
    return PromptedText(embedder)
