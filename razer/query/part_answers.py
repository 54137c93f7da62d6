"""Parts as answers: of a part and its whole, which is meant."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array, IndexArray

# A part looks much as its whole does, and its vectors are fewer and noisier: asked for a chair, its seat is no answer
# because it is a little surer, nor because it is sure to the ninth digit and the chair to the third. Natural logarithm
# of the ratio of odds, and the doubt below which both are certain; figures in docs/queries.md.
FITS_BETTER = 1.0
CERTAIN = 0.01


def better_parts(parts: Float64Array, wholes: Float64Array, threshold: float) -> IndexArray:
    """Rows of the parts that are answers by their scores (P,): those that reach a threshold and fit better than their
    wholes do, by the scores (P,) of these, 0 where a whole has none."""
    better = _log_odds(parts) - _log_odds(wholes) > FITS_BETTER
    return np.flatnonzero((parts >= threshold) & better)


def _log_odds(scores: Float64Array) -> Float64Array:
    likely = np.clip(scores, CERTAIN, 1 - CERTAIN)
    odds: Float64Array = np.log(likely / (1 - likely))
    return odds
