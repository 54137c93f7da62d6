"""Precomputed text embeddings of names, read from a file: text queries without a text encoder."""

from __future__ import annotations

import difflib
import hashlib
import re
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path

import numpy as np

from razer.arrays import Float32Array, Float64Array
from razer.errors import BadInput
from razer.files import MALFORMED, read_npz

_PROMPT = re.compile(r"^((a|an|the)\s+)?(photo|picture|image)\s+of\s+")
_ARTICLE = re.compile(r"^(a|an|the)\s+")
_SYNONYM_COSINE = 0.999  # from which two names mean one class
_NULL_SHARE = 8  # one in so many directions counts as one in which the names of a table hardly differ


class NameVectorTable:
    """NumPy archives with `names` (N,), `text` (N, D) and, if known, `synonyms` (N,) separated by '|'.

    Several archives of one space, a list or a text with commas, are one table: a name counts where it comes first, a
    synonym where no name is called so. A name or synonym matches in any case, with spaces or underscores, with or
    without an article or "a photo of". Raises BadInput.
    """

    def __init__(self, files: str | Path | Sequence[str | Path]) -> None:
        self.files = _paths(files)
        names: list[str] = []
        vectors: list[Float32Array] = []
        by_name: dict[str, int] = {}
        by_synonym: dict[str, int] = {}
        for file in self.files:
            own_names, text, synonyms = _read(file)
            rows = {}
            for number, name in enumerate(own_names):
                rows[number] = by_name.get(bare_name(name), len(names))
                if rows[number] == len(names):
                    names.append(name)
                    vectors.append(text[number])
            own = {bare_name(word): rows[n] for n, words in enumerate(synonyms) for word in words.split("|")}
            by_synonym = own | by_synonym
            by_name = {bare_name(name): rows[n] for n, name in enumerate(own_names)} | by_name
        self.names = tuple(names)
        self.vectors = _stacked(vectors, self.files)
        self._rows = by_synonym | by_name

    def embed_texts(self, texts: Sequence[str]) -> Float32Array:
        """Unit vectors (N, D) of names or synonyms; raises BadInput, with the nearest ones, for any other name."""
        for text in texts:
            if bare_name(text) not in self._rows:
                raise BadInput(f"{' and '.join(map(str, self.files))} has no '{text}': {self._nearest_names(text)}")
        return self.vectors[[self._rows[bare_name(text)] for text in texts]]

    def has_name(self, text: str) -> bool:
        """Whether a text is a name or a synonym, told sooner than `embed_texts` explains that it is none."""
        return bare_name(text) in self._rows

    def embed_class(self, name: str) -> Float32Array:
        """The unit vector (D,) of a class. A name that the table lacks has a vector of its own, in the directions
        in which the table's vectors are shortest, and so is near none of them."""
        row = self._rows.get(bare_name(name))
        if row is not None:
            return self.vectors[row]
        seed = np.frombuffer(hashlib.sha256(bare_name(name).encode()).digest()[:16], "<u8")
        vector = self._null_directions @ np.random.default_rng(seed).standard_normal(self._null_directions.shape[1])
        return (vector / np.linalg.norm(vector)).astype(np.float32)

    def unrelated_cosine(self) -> float:
        """The median of the cosines between names."""
        return median_cosine(self.vectors)

    @cached_property
    def _null_directions(self) -> Float64Array:
        """Unit directions (D, K), those of the smallest eigenvalues of the table's scatter matrix."""
        vectors = self.vectors.astype(np.float64)
        directions: Float64Array = np.linalg.eigh(vectors.T @ vectors)[1]
        return directions[:, : -(-len(directions) // _NULL_SHARE)]

    def _nearest_names(self, text: str) -> str:
        close = difflib.get_close_matches(bare_name(text), self._rows, n=3, cutoff=0)
        names = ", ".join(dict.fromkeys(self.names[self._rows[word]] for word in close))
        return f"the nearest names it knows are {names}; other words take an embedder with a text encoder"


def median_cosine(vectors: Float32Array) -> float:
    """The median cosine of any two of (N, D) unit vectors that differ; 0 if there are none."""
    cosines = (vectors @ vectors.T)[np.triu_indices(len(vectors), 1)]
    cosines = cosines[cosines < _SYNONYM_COSINE]
    return float(np.median(cosines)) if len(cosines) else 0.0


def bare_name(text: str) -> str:
    """A name as it is compared: lower case, single spaces, without article or "a photo of"."""
    name = " ".join(re.sub(r"[_\s]+", " ", text.lower()).split()).rstrip(".")
    return _ARTICLE.sub("", _PROMPT.sub("", name))


def _paths(files: str | Path | Sequence[str | Path]) -> tuple[Path, ...]:
    """The files of a list, or of a text with commas that is no file itself."""
    if isinstance(files, str) and not Path(files).expanduser().is_file():
        files = [file.strip() for file in files.split(",")]
    listed = [files] if isinstance(files, str | Path) else files
    return tuple(Path(file).expanduser() for file in listed)


def _stacked(vectors: Sequence[Float32Array], files: Sequence[Path]) -> Float32Array:
    """All rows (N, D); raises BadInput where the files are of different spaces."""
    if len(sizes := sorted({len(vector) for vector in vectors})) > 1:
        names = ", ".join(map(str, files))
        raise BadInput(f"{names} hold vectors of {sizes[0]} and {sizes[-1]} numbers: tables must be of one space")
    return np.stack(vectors)


def _read(file: Path) -> tuple[tuple[str, ...], Float32Array, list[str]]:
    """Names, unit vectors and synonyms ('' = none known); raises BadInput."""
    if not file.is_file():
        raise BadInput(f"no file {file}: set option table to a NumPy archive with names and text")
    try:
        arrays = read_npz(file)
        names, text = arrays["names"], arrays["text"].astype(np.float64)
        synonyms = arrays.get("synonyms", names)
    except MALFORMED as error:
        raise BadInput(f"{file} is no NumPy archive with names and text: {error}") from error
    if text.ndim != 2 or not len(text) or names.shape != text.shape[:1] or synonyms.shape != names.shape:
        raise BadInput(f"{file}: names {names.shape}, synonyms {synonyms.shape} and text {text.shape} do not fit")
    length = np.linalg.norm(text, axis=1, keepdims=True)
    if not (np.isfinite(length).all() and length.all()):
        raise BadInput(f"{file}: each row of text must be finite and not zero")
    return tuple(map(str, names)), (text / length).astype(np.float32), list(map(str, synonyms))
