"""Place recognition: the keyframes that a view may show again, by the words they share."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slam.backend.inverted_index import InvertedIndex
from slam.frontend.keyframes import View

MAD_TO_SIGMA = 1.4826  # from the median absolute deviation of a normal distribution to its standard deviation


class PlaceRecognition:
    """Keyframes by appearance, in the order in which they were added."""

    def __init__(self) -> None:
        self._index = InvertedIndex()

    def add(self, view: View) -> None:
        """A further keyframe."""
        self._index.add(view.wide.features.descriptors)

    def lookalikes(self, view: View, among: Sequence[int], min_sigmas: float, limit: int) -> list[int]:
        """The keyframes whose appearance is most similar to a view's, the most similar first.

        Args:
            view: the view that is compared.
            among: numbers of the keyframes it is compared with.
            min_sigmas: how far the similarity must stand out among all of them, robust standard deviations.
            limit: most keyframes that are returned.
        """
        if not among:
            return []
        numbers = np.array(among)
        similarity = self._index.similarity(view.wide.features.descriptors)[numbers]
        middle = np.median(similarity)
        sigma = MAD_TO_SIGMA * float(np.median(np.abs(similarity - middle)))
        best = np.argsort(-similarity, kind="stable")[:limit]
        return [int(numbers[n]) for n in best if similarity[n] > 0 and similarity[n] - middle >= min_sigmas * sigma]
