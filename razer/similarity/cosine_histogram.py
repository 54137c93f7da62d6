"""Histogram of cosines with trimmed quantiles: what a population looks like beside a minority that is not of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from razer.arrays import Float64Array

BINS_PER_UNIT = 1000
# Up to this share of a population may be strangers, all on one side of it, before its centre is theirs: two things of
# one frame may be two chairs, and one vector in ten of a thing may be that of another.
MAX_STRANGERS = 1 / 3
# Share of a normal distribution below its mean less one standard deviation.
_ONE_SIGMA_SHARE = 0.1587


class CosineHistogram:
    """Counts of cosines on a grid of 0.001, in whatever order they came."""

    def __init__(self) -> None:
        self._counts = np.zeros(2 * BINS_PER_UNIT + 1, np.int64)

    def __len__(self) -> int:
        return int(self._counts.sum())

    def add(self, cosines: NDArray) -> None:
        """Take in cosines of any shape, in [-1, 1]; those of vectors that are none are left out."""
        finite = cosines[np.isfinite(cosines)]
        bins = np.rint((finite.clip(-1, 1) + 1) * BINS_PER_UNIT).astype(np.int64)
        self._counts += np.bincount(bins, minlength=len(self._counts))

    def share_above(self, cosine: float) -> float:
        """Share of all that lies above a cosine; 0 while empty."""
        first = int(np.floor((cosine + 1) * BINS_PER_UNIT)) + 1
        return float(self._counts[first:].sum() / max(len(self), 1))

    def below_strangers(self) -> tuple[float, float]:
        """Median and standard deviation of the lower two thirds; 0 while empty."""
        centre, low = self._quantiles((1 - MAX_STRANGERS) / 2, (1 - MAX_STRANGERS) * _ONE_SIGMA_SHARE)
        return float(centre), float(centre - low)

    def above_strangers(self) -> tuple[float, float]:
        """Median and standard deviation of the upper two thirds, that of the wider side: views of one thing agree well
        or less well, but never by more than 1; 0 while empty."""
        own = 1 - MAX_STRANGERS
        centre, high, low = self._quantiles(
            MAX_STRANGERS + own / 2, 1 - own * _ONE_SIGMA_SHARE, MAX_STRANGERS + own * _ONE_SIGMA_SHARE
        )
        return float(centre), float(max(high - centre, centre - low))

    def _quantiles(self, *levels: float) -> Float64Array:
        total = np.cumsum(self._counts)
        if not total[-1]:
            return np.zeros(len(levels))
        return np.searchsorted(total, np.array(levels) * total[-1]) / BINS_PER_UNIT - 1
