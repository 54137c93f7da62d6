"""Place recognition: the keyframes that a view may show again, by the words they share."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from razer.arrays import Float32Array, IndexArray
from slam.backend.inverted_index import InvertedIndex
from slam.frontend.keyframes import View
from slam.frontend.wide_features import levels

MAD_TO_SIGMA = 1.4826  # from the median absolute deviation of a normal distribution to its standard deviation
MIN_SIGMA = 1e-4  # of a share, which is what noise makes of it; where few are compared all may be the same


class PlaceRecognition:
    """Keyframes by appearance, in the order in which they were added."""

    def __init__(self) -> None:
        self._index = InvertedIndex()

    def add(self, view: View) -> None:
        """A further keyframe."""
        self._index.add(levels(view.wide.prominent.descriptors))

    def lookalikes(self, view: View, among: Sequence[int] | IndexArray, min_sigmas: float, limit: int) -> list[int]:
        """The keyframes whose appearance is most similar to a view's, the most similar first.

        Args:
            view: the view that is compared.
            among: numbers of the keyframes it is compared with.
            min_sigmas: how far the similarity must stand out among all of them, robust standard deviations.
            limit: most keyframes that are returned.
        """
        if len(among) == 0:
            return []
        numbers = np.array(among)
        sigmas = _sigmas(self._index.similarity(levels(view.wide.prominent.descriptors))[numbers])
        best = np.argsort(-sigmas, kind="stable")[:limit]
        return [int(numbers[n]) for n in best if sigmas[n] >= min_sigmas]


def _sigmas(similarity: Float32Array) -> Float32Array:
    """How far each stands out, robust standard deviations."""
    above = similarity - np.median(similarity)
    sigma = MAD_TO_SIGMA * np.median(np.abs(above))
    result: Float32Array = above / max(float(sigma), MIN_SIGMA)
    return result
