"""Parts as answers: of a part and its whole, which is meant."""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array, IndexArray

# A part looks much as its whole does, and its vectors are fewer and noisier: asked for a chair, its seat is an answer
# only if it is far more likely one than the chair. Natural logarithm of the ratio of odds; figures in docs/queries.md.
FITS_BETTER = 2.0
_SUREST = 1e-12


def better_parts(parts: Float64Array, wholes: Float64Array, threshold: float) -> IndexArray:
    """Rows of the parts that are answers by their scores (P,): those that reach a threshold and fit better than their
    wholes do, by the scores (P,) of these, 0 where a whole has none."""
    better = _log_odds(parts) - _log_odds(wholes) > FITS_BETTER
    return np.flatnonzero((parts >= threshold) & better)


def _log_odds(scores: Float64Array) -> Float64Array:
    likely = np.clip(scores, _SUREST, 1 - _SUREST)
    odds: Float64Array = np.log(likely / (1 - likely))
    return odds
