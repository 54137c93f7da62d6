"""Usual colours: what share of colours differs between two pictures of one place, learnt from a recording.

It grows with how far apart pictures were taken, as exposure, reflections and edges differ the more, and from camera to
camera. Look-alikes differ the same from wherever they are seen: what tells them is that pictures taken as if from one
place do not go together.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from razer.arrays import Float64Array
from slam.sparse.measured_pair import MeasuredPair

MOST_BINS, LEAST_PAIRS = 8, 12  # of pairs by how far apart they are, and in each
LEAST_USUAL = 0.003  # share of other colours that is noise


class UsualColors:
    """The share of other colours of pairs as far apart as a separation: between medians of pairs of all separations,
    none of which is more than one farther out, so that look-alikes at few separations do not count."""

    def __init__(self, pairs: Sequence[MeasuredPair]) -> None:
        ranked = sorted(pairs, key=lambda pair: pair.separation)
        n_bins = max(1, min(MOST_BINS, len(ranked) // LEAST_PAIRS))
        bins = [[ranked[n] for n in numbers] for numbers in np.array_split(np.arange(len(ranked)), n_bins)]
        separations = [np.median([pair.separation for pair in one]) if one else 1.0 for one in bins]
        shares = [np.median([pair.other_colors for pair in one]) if one else 0.0 for one in bins]
        self._separations = np.array([0.0, *separations])
        self._shares = np.array([0.0, *np.minimum.accumulate(shares[::-1])[::-1]])

    def mean(self, separations: Sequence[float]) -> float:
        """Mean of the usual shares at separations, of which there is one at least; farther out than any pair they go on
        in proportion."""
        asked = np.asarray(separations, np.float64)
        return float(np.maximum(self._at(asked), LEAST_USUAL).mean())

    def _at(self, separations: Float64Array) -> Float64Array:
        farthest = self._separations[-1]
        within = np.interp(separations, self._separations, self._shares)
        return within * np.maximum(separations / max(farthest, 1e-9), 1.0)
