"""Usual colours: what share of colours differs between two views of one place, learnt from a recording.

It grows with how far apart views were taken, as exposure, reflections and edges differ the more, and from camera to
camera. Look-alikes differ the same from wherever they are seen: what tells them is that views taken as if from one
place do not go together.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from razer.arrays import Float64Array

MOST_BINS, LEAST_PAIRS = 8, 12  # of pairs by how far apart they are, and in each
LEAST_USUAL = 0.003  # share of other colours that is noise
# Times the square of the separation: the share of a hand-held camera with automatic exposure (7-Scenes' redkitchen),
# which is not held against a recording before it has told how much its own is.
HAND_HELD = 0.35
NOISE = 0.001  # share of other colours that says nothing, of pairs that lie where they belong
# What a pair says, in doublings of the usual share: nothing at twice as much, and no more than this for one place and
# for two. Within twin rooms 90 of 100 pairs have less than 1.4 times the usual, across them the median is 2 to 5 times;
# within a kitchen 90 of 100 have less than twice.
ONE_PLACE, TWO_PLACES = -1.5, 3.0
FULL_READINGS = 1500  # shared ones, a third of a view, from which a pair says all of that


class UsualColors:
    """The share of other colours of views as far apart as a separation: between medians of pairs of all separations,
    none of which is more than one farther out, so that look-alikes at few separations do not count.

    Args:
        separations: (N,) of pairs, most of which are of one place, see `separation`; fewer than LEAST_PAIRS do not
            tell that little differs.
        shares: (N,) their shares of other colours, see `other_colors`.
        least: share that is noise.
    """

    def __init__(self, separations: Sequence[float], shares: Sequence[float], least: float = LEAST_USUAL) -> None:
        order = np.argsort(separations, kind="stable")
        bins = np.array_split(order, max(1, min(MOST_BINS, len(order) // LEAST_PAIRS)))
        medians = [np.median(np.asarray(shares)[one]) if len(one) else 0.0 for one in bins]
        middles = [np.median(np.asarray(separations)[one]) if len(one) else 1.0 for one in bins]
        self._separations, self._least = np.array([0.0, *middles]), least
        self._is_told = len(order) >= LEAST_PAIRS
        self._shares = np.array([0.0, *np.minimum.accumulate(medians[::-1])[::-1]])

    def at(self, separations: Sequence[float]) -> Float64Array:
        """The usual shares (N,) at separations; farther out than any pair they grow with the square."""
        return np.maximum(self._learnt(np.asarray(separations, np.float64)), self._least)

    def _learnt(self, separations: Float64Array) -> Float64Array:
        farthest = self._separations[-1]
        within = np.interp(separations, self._separations, self._shares)
        learnt = within * np.maximum(separations / max(farthest, 1e-9), 1.0) ** 2
        return learnt if self._is_told else np.maximum(learnt, HAND_HELD * separations**2)


def place_weights(shares: Float64Array, usual: Float64Array) -> Float64Array:
    """What shares of other colours (N,) say beside usual ones (N,): more than 0 for two places, less for one. No pair
    says much; that most of them have more than usual does."""
    doublings = np.log2((shares + NOISE) / (usual + NOISE))
    weights: Float64Array = (doublings - 1).clip(ONE_PLACE, TWO_PLACES)
    return weights


def reading_weights(n_readings: Float64Array) -> Float64Array:
    """How much pairs (N,) count by the readings they share."""
    return np.minimum(n_readings / FULL_READINGS, 1)
