"""Text embeddings of class names as mask vectors, so that a closed-set segmenter can be queried by text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from razer.arrays import Float32Array
from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models import Embedder, TextEncoder, make_embedder
from razer.models.name_vectors.name_table import NameVectorTable
from razer.models.name_vectors.prompt_ensemble import PromptEnsemble


class NamesEmbedder:
    """The text vector of each mask's class name, from one of two sources.

    A mask whose name the table lacks, or that has an empty one, gets a vector of that name's own, near no name of the
    table: the tracker keeps masks of one name together and others apart, and no query returns them by chance. A mean
    vector of all names would be nearer to most queries than any wrong name is.

    Args:
        table: a file of names and their text vectors, or several (see NameVectorTable); other names cannot be queried.
        embedder: an embedder with a text encoder, by name or as an object, which takes any name.
        embedder_options: options of that embedder, where it is given by name.

    Raises:
        BadInput: unless there is one of the two sources, and it can be used.
    """

    embeds_names = True  # votes for names say as much

    def __init__(
        self,
        table: str | Path | Sequence[str | Path] | None = None,
        embedder: str | Embedder | None = None,
        embedder_options: Mapping[str, Any] | None = None,
    ) -> None:
        if (table is None) == (embedder is None):
            raise BadInput("the names embedder takes either option table, a file of text vectors, or option embedder")
        self._source = NameVectorTable(table) if table else _encoder(embedder or "", embedder_options or {})
        self._vectors: dict[str, Float32Array] = {}

    @property
    def known_names(self) -> tuple[str, ...]:
        """The names of the table, synonyms left out; none where any name is known."""
        return self._source.names

    @property
    def takes_any_name(self) -> bool:
        """Whether names go through an encoder, which is slower and takes any name."""
        return isinstance(self._source, PromptEnsemble)

    @cached_property
    def unrelated_cosine(self) -> float:
        """The median cosine between the vectors of two names."""
        return self._source.unrelated_cosine()

    def embed_texts(self, texts: Sequence[str]) -> Float32Array:
        """Unit vectors (N, D) of names, no sentences; raises BadInput for a name that the table lacks."""
        return self._source.embed_texts(texts)

    def has_name(self, text: str) -> bool:
        """Whether a text has a vector."""
        return self._source.has_name(text)

    def embed(self, frame: Frame, masks: Masks) -> Float32Array:
        """Unit vectors (N, D) of the masks' class names; raises BadInput for masks without names."""
        if len(masks) and masks.class_names is None:
            raise BadInput(
                "the names embedder needs masks with class names: use a segmenter that names what it finds, such as "
                "yolo, or another embedder"
            )
        vectors = [self._vector(name) for name in masks.class_names or ()]
        return np.stack(vectors) if vectors else np.zeros((0, len(self._vector(""))), np.float32)

    def _vector(self, name: str) -> Float32Array:
        if name not in self._vectors:
            self._vectors[name] = self._source.embed_class(name)
        return self._vectors[name]


def _encoder(name_or_embedder: str | Embedder, options: Mapping[str, Any]) -> PromptEnsemble:
    embedder = make_embedder(name_or_embedder, options) if isinstance(name_or_embedder, str) else name_or_embedder
    if not isinstance(embedder, TextEncoder):
        raise BadInput(
            f"embedder '{name_or_embedder}' has no text encoder: the names embedder needs one that knows words"
        )
    return PromptEnsemble(embedder)
