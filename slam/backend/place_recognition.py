"""Place recognition by bags of visual words: the keyframes most similar to a view.

The words are descriptors met in this very recording, added wherever none is near them yet; so there is no
vocabulary to download, and the cost of a question is that of one product of a matrix and a vector (Sivic and
Zisserman, ICCV 2003; growing vocabularies: Nicosevici and Garcia, T-RO 2012).
"""

from __future__ import annotations

import cv2
import numpy as np

from razer.arrays import Float32Array, Float64Array, IndexArray, Uint8Array
from slam.frontend.features import Features

MAX_WORDS = 2048  # enough for a flat; the cost of a question grows with them
NEW_WORD_BITS = 50  # a descriptor farther than this from every word may become one
SAME_WORD_BITS = 50  # and one nearer is an instance of it
WORDS_PER_VIEW = 60  # at most, so that the first views do not take them all
MAX_LOOKED_UP = 450  # features of a view that are looked up; more make the answer no better
REWEIGH_GROWTH = 1.05  # words get new weights once there are so many times more keyframes
MIN_NORM = 1e-12  # of a squared norm, so that a view without words is like none


class PlaceRecognition:
    """Keyframes by appearance, in the order in which they were added."""

    def __init__(self) -> None:
        self._words = np.zeros((0, 32), np.uint8)
        self._counts = np.zeros((64, MAX_WORDS), np.float32)
        self._norms = np.zeros(64, np.float32)
        self._n_containing = np.zeros(MAX_WORDS, np.int64)
        self._weights = np.ones(MAX_WORDS, np.float32)
        self._size = self._size_at_weights = 0

    def add(self, features: Features) -> None:
        """A further keyframe."""
        self._add_words(features)
        if self._size == len(self._counts):
            self._counts = np.concatenate([self._counts, np.zeros_like(self._counts)])
            self._norms = np.concatenate([self._norms, np.zeros_like(self._norms)])
        bag = self._bag(features)
        self._counts[self._size] = bag
        self._n_containing += bag > 0
        self._norms[self._size] = self._norm(bag)
        self._size += 1
        if self._size > REWEIGH_GROWTH * self._size_at_weights:
            self._update_weights()

    def similarity(self, features: Features) -> Float32Array:
        """How alike (K,) each keyframe is, in [0, 1]: cosine of the bags, rare words weighing more (tf-idf)."""
        bag = self._bag(features)
        products = self._counts[: self._size] @ (bag * self._weights)
        similarity: Float32Array = products / (self._norms[: self._size] * self._norm(bag))
        return similarity

    def _update_weights(self) -> None:
        """Inverse document frequencies change slowly; so do the norms that follow from them."""
        self._weights = np.square(np.log((1 + self._size) / (1 + self._n_containing))).astype(np.float32)
        counts = self._counts[: self._size]
        self._norms[: self._size] = np.sqrt(np.maximum(np.square(counts) @ self._weights, MIN_NORM))
        self._size_at_weights = self._size

    def _norm(self, bag: Float32Array) -> float:
        return float(np.sqrt(max(float(np.square(bag) @ self._weights), MIN_NORM)))

    def _add_words(self, features: Features) -> None:
        room = min(WORDS_PER_VIEW, MAX_WORDS - len(self._words))
        if room <= 0 or len(features) == 0:
            return
        fresh = np.flatnonzero(self._nearest(features.descriptors)[1] > NEW_WORD_BITS)[:room]
        self._words = np.concatenate([self._words, features.descriptors[fresh]])

    def _nearest(self, descriptors: Uint8Array) -> tuple[IndexArray, Float64Array]:
        """The nearest word of each descriptor (N, 32) and its distance in bits."""
        if len(self._words) == 0:
            return np.zeros(len(descriptors), np.intp), np.full(len(descriptors), np.inf)
        nearest = cv2.BFMatcher(cv2.NORM_HAMMING).match(descriptors, self._words)
        return np.array([m.trainIdx for m in nearest], np.intp), np.array([m.distance for m in nearest])

    def _bag(self, features: Features) -> Float32Array:
        if len(features) == 0 or len(self._words) == 0:
            return np.zeros(MAX_WORDS, np.float32)
        word, bits = self._nearest(features.descriptors[:: -(-len(features) // MAX_LOOKED_UP)])
        # A descriptor far from every word has none: else words added later would make all later views similar.
        return np.sqrt(np.bincount(word[bits <= SAME_WORD_BITS], minlength=MAX_WORDS)).astype(np.float32)
