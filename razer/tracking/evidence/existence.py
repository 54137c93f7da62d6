"""Existence evidence of a track: the log-odds that it is a thing and no phantom, from the views that showed it or
should have (the confidence of RAZER's problem formulation; the bookkeeping of occupancy mapping, for tracks).

A thing is detected at some rate in the views that show it, one in five or nine in ten, which nobody knows beforehand;
a phantom hardly ever comes back. So both are compared by how likely they make the detections and the misses counted so
far, the rate of the thing averaged out. Views and not frames are counted: a frame from nearly the same place says
little new."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# Rates at which things are detected where they are in view, equally likely beforehand, and the rate at which a phantom
# comes back. Detectors find some real furniture in a fifth of the views.
DETECTION_RATES = np.array([0.2, 0.4, 0.6, 0.9])
PHANTOM_RATE = 0.03
# Views after which half of what was counted is forgotten: what was carried away is gone after a while, however often
# it was seen.
HALF_LIFE_VIEWS = 100.0
# A mask's score is not taken for more sure than this, nor for less.
MIN_DOUBT = 0.2


@dataclass
class Existence:
    """Detections and misses of a track, in views, and the score of its first detection."""

    first_score: float
    hits: float = 0.0
    misses: float = 0.0

    def count(self, hit: float, miss: float) -> None:
        """Take in one view, a part of which may be a detection and a part a miss."""
        kept = 0.5 ** ((hit + miss) / HALF_LIFE_VIEWS)
        self.hits, self.misses = kept * self.hits + hit, kept * self.misses + miss

    def absorb(self, other: Existence) -> None:
        """Become one with a duplicate: while one of both was matched, the other was not missed."""
        self.first_score = max(self.first_score, other.first_score)
        self.hits, self.misses = max(self.hits, other.hits), min(self.misses, other.misses)

    @property
    def log_odds(self) -> float:
        """ln P(thing) / P(phantom), natural logarithm."""
        score = min(max(self.first_score, MIN_DOUBT), 1 - MIN_DOUBT)
        thing = self.hits * np.log(DETECTION_RATES) + self.misses * np.log(1 - DETECTION_RATES)
        phantom = self.hits * np.log(PHANTOM_RATE) + self.misses * np.log(1 - PHANTOM_RATE)
        return float(np.log(score / (1 - score)) + np.logaddexp.reduce(thing) - np.log(len(thing)) - phantom)

    @property
    def probability(self) -> float:
        """P(thing)."""
        return float(1 / (1 + np.exp(-np.clip(self.log_odds, -50, 50))))
