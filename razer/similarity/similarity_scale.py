"""Similarity calibration: cosines in units of *unlike ... same*, learnt from what the map sees.

An embedder's cosines say little by themselves: pictures of unlike things are at 0.72 on average with CLIP ViT-B/32,
the simulator's views of one thing at 0.49. In units, 0 is as alike as two unlike things are on average and 1 as
alike as two views of one thing."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import log
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from razer.arrays import Float64Array
from razer.similarity.cosine_histogram import CosineHistogram

Cosines = TypeVar("Cosines", float, Float64Array)

# Cosines that weigh as much as the prior of their population. It fades with the square of their number: it is for the
# first frames only, and far off in a space where unlike and same are hardly apart.
PRIOR_COUNT = 10
# Prior standard deviation of both populations, of the way from unlike to same.
PRIOR_SPREAD = 0.15
# Identical vectors for a class are no proof: cosines differ by at least this much.
MIN_SPREAD = 0.02
# Shares of matches that look unlike, and of other things that look the same: what bounds the evidence of one cosine.
PRIOR_STRANGERS = 0.1
MIN_STRANGERS = 0.1
MAX_STRANGERS = 0.4
# The most that one cosine can say, either way. It is P(c | same) / P(c | unlike), each of which is (1 - s) p + s q with
# the densities p of its own kind and q of the other; where q = 0 what is left is (1 - s) p / s p. ln 9 = 2.2.
MAX_LOG_ODDS = log((1 - MIN_STRANGERS) / MIN_STRANGERS)


@dataclass(frozen=True)
class CosinePopulation:
    """Mean and standard deviation of cosines of one kind of pairs, and the share of pairs that look like the other
    kind."""

    mean: float
    spread: float
    strangers: float


@dataclass(frozen=True)
class CalibratedScale:
    """Units and evidence of cosines from two populations: pairs of unlike things, pairs of views of one thing."""

    unlike: CosinePopulation
    same: CosinePopulation

    @cached_property
    def separation(self) -> float:
        """How far the populations are apart, in [0, 1]: 1 from one standard deviation on; 0, cosines say nothing."""
        spread_squared = (self.unlike.spread**2 + self.same.spread**2) / 2
        return min(1.0, max(self.same.mean - self.unlike.mean, 0.0) ** 2 / spread_squared)

    @cached_property
    def units_per_cosine(self) -> float:
        """The slope of `units`."""
        return self.separation / max(self.same.mean - self.unlike.mean, 1e-9)

    def units(self, cosine: Cosines) -> Cosines:
        """Cosines, single or (N,), as units. Where the populations overlap so far that cosines say nothing, all
        approach 1, so that a threshold on them forbids nothing."""
        return 1 + (cosine - self.same.mean) * self.units_per_cosine

    def log_odds(self, units: Cosines) -> Cosines:
        """How much more likely (natural logarithm) a similarity is between two views of one thing than between unlike
        things; monotone, 0 where cosines say nothing.

        Each kind of pairs is a normal distribution with a share of the other, as some views carry a wrong vector and
        some things have a twin: this bounds what a single cosine can say (`MAX_LOG_ODDS`). What is beyond either mean
        says no more than the mean."""
        unlike_mean, slope = 1 - self.separation, max(self.units_per_cosine, 1e-9)
        between = np.clip(units, unlike_mean, 1.0)
        ratio = _log_normal(between, 1.0, slope * self.same.spread)
        ratio = ratio - _log_normal(between, unlike_mean, slope * self.unlike.spread)
        same = np.logaddexp(np.log1p(-self.same.strangers) + ratio, np.log(self.same.strangers))
        unlike = np.logaddexp(np.log1p(-self.unlike.strangers), np.log(self.unlike.strangers) + ratio)
        result: Cosines = self.separation * (same - unlike)
        return result


class SimilarityScale:
    """The scale of an embedder's cosines, from the pairs observed so far and a prior that fades with their number.

    Constant memory; the same whatever the order of the pairs."""

    def __init__(self, unrelated_cosine: float = 0.0) -> None:
        """The prior: unlike things at `unrelated_cosine`, views of one thing at 1."""
        self._prior = unrelated_cosine
        self._unlike, self._same = CosineHistogram(), CosineHistogram()
        self._calibrated: CalibratedScale | None = None

    def observe(self, unlike: NDArray, same: NDArray) -> None:
        """Take in cosines of pairs of unlike things, and of two views of one thing; a third of each may be wrong."""
        self._unlike.add(unlike)
        self._same.add(same)
        self._calibrated = None

    @property
    def calibrated(self) -> CalibratedScale:
        """The scale as it stands now."""
        if self._calibrated is None:
            self._calibrated = self._estimate()
        return self._calibrated

    def units(self, cosine: Cosines) -> Cosines:
        """As `CalibratedScale.units`, by the scale as it stands."""
        return self.calibrated.units(cosine)

    def log_odds(self, units: Cosines) -> Cosines:
        """As `CalibratedScale.log_odds`, by the scale as it stands."""
        return self.calibrated.log_odds(units)

    def _estimate(self) -> CalibratedScale:
        spread = PRIOR_SPREAD * (1 - self._prior)
        unlike = _posterior((self._prior, spread), self._unlike.below_strangers(), len(self._unlike))
        same = _posterior((1.0, spread), self._same.above_strangers(), len(self._same))
        between = (unlike[0] + same[0]) / 2
        seems_same = self._unlike.share_above(between) - ndtr((unlike[0] - between) / unlike[1])
        seems_unlike = 1 - self._same.share_above(between) - ndtr((between - same[0]) / same[1])
        return CalibratedScale(
            CosinePopulation(*unlike, _strangers(seems_same, len(self._unlike))),
            CosinePopulation(*same, _strangers(seems_unlike, len(self._same))),
        )


def _posterior(prior: tuple[float, float], observed: tuple[float, float], count: int) -> tuple[float, float]:
    """Mean and spread: the prior's, and those of `count` observations by their weight."""
    weight = _weight(count)
    mean, spread = ((1 - weight) * p + weight * o for p, o in zip(prior, observed, strict=True))
    return mean, max(spread, MIN_SPREAD)


def _weight(count: int) -> float:
    return count**2 / (count**2 + PRIOR_COUNT**2)


def _strangers(observed: float, count: int) -> float:
    """Share of strangers, observed beyond what the spread alone puts on the other side."""
    share = _weight(count) * observed + (1 - _weight(count)) * PRIOR_STRANGERS
    return float(np.clip(share, MIN_STRANGERS, MAX_STRANGERS))


def _log_normal(values: Cosines, mean: float, spread: float) -> Cosines:
    """Logarithm of a normal density, without its constant factor."""
    result: Cosines = -(((values - mean) / spread) ** 2) / 2 - np.log(spread)
    return result
