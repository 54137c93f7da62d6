"""Which keyframes look like a view: bags of visual words, one matrix product for all of them.

The words are descriptors met in this very recording, added wherever nothing like them is known yet; so there is no
vocabulary to download, and the cost of a question is that of a matrix product (Sivic and Zisserman, ICCV 2003;
growing vocabularies: Nicosevici and Garcia, T-RO 2012).
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from slam.features import Features

MAX_WORDS = 2048
NEW_WORD_BITS = 50  # a descriptor farther than this from every word may become one
SAME_WORD_BITS = 50  # and one nearer is an instance of it
WORDS_PER_VIEW = 60


class Places:
    """Keyframes by appearance, in the order in which they were added."""

    def __init__(self) -> None:
        self._words = np.zeros((0, 32), np.uint8)
        self._matcher = cv2.BFMatcher(cv2.NORM_HAMMING)
        self._counts = np.zeros((64, MAX_WORDS), np.float32)
        self._size = 0

    def add(self, features: Features) -> None:
        """A further keyframe."""
        self._learn(features)
        if self._size == len(self._counts):
            self._counts = np.concatenate([self._counts, np.zeros_like(self._counts)])
        self._counts[self._size] = self._bag(features)
        self._size += 1

    def similar(self, features: Features) -> NDArray[np.float32]:
        """How alike (K,) each keyframe is, in [0, 1]: cosine of the bags, rare words weighing more (tf-idf)."""
        counts = self._counts[: self._size]
        rarity = np.log((1 + self._size) / (1 + np.count_nonzero(counts, axis=0))).astype(np.float32)
        bag = self._bag(features) * rarity**2
        norms = np.sqrt(np.maximum((counts**2) @ rarity**2, 1e-12))
        norm = np.sqrt(max(float(bag @ self._bag(features)), 1e-12))
        return (counts @ bag) / (norms * norm)

    def _learn(self, features: Features) -> None:
        room = min(WORDS_PER_VIEW, MAX_WORDS - len(self._words))
        if room <= 0 or len(features) == 0:
            return
        fresh = np.flatnonzero(self._nearest(features)[1] > NEW_WORD_BITS)[:room]
        self._words = np.concatenate([self._words, features.descriptors[fresh]])

    def _nearest(self, features: Features) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
        """The nearest word of each feature and its distance in bits."""
        if len(self._words) == 0:
            return np.zeros(len(features), np.intp), np.full(len(features), np.inf)
        found = self._matcher.match(features.descriptors, self._words)
        return np.array([m.trainIdx for m in found], np.intp), np.array([m.distance for m in found])

    def _bag(self, features: Features) -> NDArray[np.float32]:
        if len(features) == 0 or len(self._words) == 0:
            return np.zeros(MAX_WORDS, np.float32)
        word, bits = self._nearest(features)
        # What is like no word has none: else words learnt later would make all later views look alike.
        return np.sqrt(np.bincount(word[bits <= SAME_WORD_BITS], minlength=MAX_WORDS)).astype(np.float32)
