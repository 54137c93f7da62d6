"""Exemplars: names with the embeddings of their texts and of pictures of them, both of one embedder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from razer.arrays import Float32Array, FloatArray, IndexArray
from razer.errors import BadInput
from razer.files import MALFORMED, MissingFile, read_npz


@dataclass(frozen=True)
class Exemplars:
    """names (N,), synonyms of each, text (N, D) and image (N, D), of unit length."""

    names: tuple[str, ...]
    synonyms: tuple[frozenset[str], ...]
    text: Float32Array
    image: Float32Array

    @classmethod
    def read(cls, path: Path) -> Exemplars:
        """From an npz with names, synonyms ('|' between them), text and image; raises BadInput."""
        try:
            table = read_npz(path, ["names", "synonyms", "text", "image"])
            text, image = (_unit(table[side]) for side in ("text", "image"))
        except MissingFile:
            raise BadInput(f"{path} does not exist: give an npz with names, synonyms, text and image") from None
        except MALFORMED as error:
            raise BadInput(f"{path} is no table with names, synonyms, text and image: {error}") from error
        synonyms = tuple(frozenset(str(each).split("|")) for each in table["synonyms"])
        return cls(tuple(map(str, table["names"])), synonyms, text, image)

    def present_and_absent(self, n: int, rng: np.random.Generator) -> tuple[IndexArray, IndexArray]:
        """Rows of `n` names, and of `n` others that share no synonym with any of them."""
        order = rng.permutation(len(self.names))
        present = order[:n]
        used_synonyms = frozenset().union(*(self.synonyms[row] for row in present))
        absent = [row for row in order[n:] if not self.synonyms[row] & used_synonyms][:n]
        return present, np.array(absent, np.intp)


def _unit(vectors: FloatArray) -> Float32Array:
    single = vectors.astype(np.float32)
    return single / np.maximum(np.linalg.norm(single, axis=1, keepdims=True), 1e-9)
