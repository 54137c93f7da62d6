"""When something counts as present in any of many maps: the more maps are asked, the surer the best hit must be.

The score of a hit was calibrated for one map, of which every other one has what is asked for. The best of many maps is
better by chance: with a fixed threshold a name that is in none of 30 maps is said to be present in 60 to 85 % of the
cases, in place of 8 to 16 % for one map. So the odds that are asked for rise with the number of maps, and above 30 more
slowly, as what looks like the query is among them by then; likewise for pictures. docs/library.md has the figures.
"""

from __future__ import annotations

from math import exp, log

from razer.query.ranking import PRESENT

_SATURATED = 30
_SLOWER = 0.5
_MORE_LIKENESS = 0.12


def threshold_among(n_maps: float) -> float:
    """The least score of a hit by its looks among so many maps of the usual size; `PRESENT` for one."""
    return 1 / (1 + exp(-(log(PRESENT / (1 - PRESENT)) + _more_odds(max(n_maps, 1.0)))))


def picture_threshold_among(n_maps: float) -> float:
    """The same for a picture: the least likeness, which is a cosine and no probability."""
    return PRESENT + _MORE_LIKENESS * (1 - max(n_maps, 1.0) ** -0.5)


def _more_odds(n: float) -> float:
    """By how much the logarithm of the odds must be higher."""
    return log(min(n, _SATURATED)) + _SLOWER * log(max(n, _SATURATED) / _SATURATED)
