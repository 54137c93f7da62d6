"""Inverted index of hashed SIFT descriptors: which keyframes share words with a view, rare words weighing more (tf-idf;
Sivic and Zisserman, ICCV 2003).

A word is which of two entries of a descriptor is larger, for a few fixed pairs of entries, once for each of several
tables: hashing that keeps what is near together (Gionis, Indyk and Motwani, VLDB 1999; by order: Yagnik, Strelow, Ross
and Lin, ICCV 2011). So there is no vocabulary to download, to fill, or to outgrow.
"""

from __future__ import annotations

from array import array
from collections import defaultdict
from collections.abc import Iterable
from typing import Any

import numpy as np

from razer.arrays import Float32Array, IndexArray, Int64Array, Uint8Array

N_TABLES, WORD_BITS = 8, 16  # a descriptor seen again shares a word of some table; unlike ones seldom any
CELLS, DIRECTIONS = 4, 8  # of a SIFT descriptor: cells each way, and directions of the histogram of each


class InvertedIndex:
    """Keyframes by their words, in the order in which they were added."""

    def __init__(self) -> None:
        self._first, self._second = _mirrored_pairs()
        self._postings: defaultdict[int, array[int]] = defaultdict(_posting)
        self._n_words = array("I")  # of each keyframe

    def __len__(self) -> int:
        return len(self._n_words)

    def __getstate__(self) -> dict[str, Any]:
        words = np.fromiter(self._postings, np.int64, len(self._postings))
        lengths = np.fromiter(map(len, self._postings.values()), np.int64, len(self._postings))
        keyframes = _joined(self._postings.values())
        return {"_size": len(self), "words": words, "lengths": lengths, "keyframes": keyframes}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__()  # type: ignore[misc]
        self._n_words = array("I", np.bincount(state["keyframes"], minlength=state["_size"]).tolist())
        ends = np.cumsum(state["lengths"]).tolist()
        for word, length, end in zip(state["words"].tolist(), state["lengths"].tolist(), ends, strict=True):
            self._postings[word] = array("I", state["keyframes"][end - length : end].tolist())

    def add(self, descriptors: Uint8Array) -> None:
        """A further keyframe with descriptors (N, 128)."""
        number, words = len(self), self._words(descriptors).tolist()
        for word in words:
            self._postings[word].append(number)
        self._n_words.append(len(words))

    def similarity(self, descriptors: Uint8Array) -> Float32Array:
        """How much (K,) of what tells a view with descriptors (N, 128) from others each keyframe has: 0 nothing, 1 all,
        if it has as many words as keyframes have on average.

        One with many words shares more of them with anything: as in the cosine of two vectors of words it is divided by
        the length of the keyframe's, in which all of its words weigh alike here."""
        known = self._postings.get
        found = [posting for word in self._words(descriptors).tolist() if (posting := known(word))]
        if not found:
            return np.zeros(len(self), np.float32)
        lengths = np.fromiter(map(len, found), np.int64, len(found))
        weights = np.square(np.log((1 + len(self)) / lengths))
        shared = np.bincount(_joined(found), np.repeat(weights, lengths), len(self)) / weights.sum().clip(1e-9)
        n_words = np.maximum(self._n_words, 1)
        result: Float32Array = (shared * np.sqrt(n_words.mean() / n_words)).astype(np.float32)
        return result

    def _words(self, descriptors: Uint8Array) -> Int64Array:
        """The different words of descriptors (N, 128), those of each table in a range of their own."""
        bits = descriptors[:, self._first] > descriptors[:, self._second]
        words = bits @ (1 << np.arange(WORD_BITS)) + (np.arange(N_TABLES) << WORD_BITS)
        return np.unique(words)


def _mirrored_pairs() -> tuple[IndexArray, IndexArray]:
    """Entries of descriptors (N_TABLES, WORD_BITS), and each one's mirror image, which is larger as often as not."""
    rng, shape = np.random.default_rng(0), (N_TABLES, WORD_BITS)
    row, column = rng.integers(CELLS, size=shape), rng.integers(CELLS, size=shape)
    direction, axis = rng.integers(DIRECTIONS, size=shape), rng.integers(3, size=shape)
    mirrored_row = np.where(axis != 0, CELLS - 1 - row, row)
    mirrored_column = np.where(axis != 1, CELLS - 1 - column, column)
    first = (row * CELLS + column) * DIRECTIONS + direction
    second = (mirrored_row * CELLS + mirrored_column) * DIRECTIONS + direction
    return first, second


def _posting() -> array[int]:
    return array("I")


def _joined(postings: Iterable[array[int]]) -> Int64Array:
    return np.frombuffer(b"".join(postings), np.uintc).astype(np.int64)
