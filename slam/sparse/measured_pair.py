"""Measured pair: a verified registration of two pictures, and how many others bear it out."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.pose_edge import PoseEdge

ALONE_FEATURES = 12  # wide ones, that agree, for a single pair to be believed: fewer may agree on a look-alike
BETTER = 0.25  # share of a picture's pairs that are its better ones
LEAST_COLORS = 0.001  # share of a picture that is noise
LEAST_SCORE = 0.01  # features say something where no depth agrees, too
LAST_RANK = 6  # times the usual share of other colours, from which all pairs are equally bad

Numbers = tuple[int, int]  # of two pictures


@dataclass(frozen=True)
class MeasuredPair:
    """The edge between two pictures, the features that agree, the share of points that do (score), what share of
    colours differs, how far apart they were taken (see `separation`), and whether the one was taken next after the
    other, of a camera that was carried about. Of a pair that was not registered yet, what its features say, roughly."""

    edge: PoseEdge
    n_features: int
    score: float
    other_colors: float = 0.0
    separation: float = 0.5
    is_next: bool = False
    is_registered: bool = True

    @property
    def weight(self) -> float:
        """How much it says beside others: by the features that agree, and how well the rest does."""
        return self.n_features * max(self.score, LEAST_SCORE)

    @property
    def ends(self) -> Numbers:
        """The numbers of both pictures."""
        return self.edge.a, self.edge.b

    def motion(self, start: int) -> Float64Array:
        """start_from_other (4, 4), start being one of the two pictures."""
        return self.edge.a_from_b if start == self.edge.a else inverse(self.edge.a_from_b)

    def other(self, one: int) -> int:
        """The picture that is not this one."""
        return self.edge.b if one == self.edge.a else self.edge.a


def by_picture(pairs: Sequence[MeasuredPair]) -> dict[int, dict[int, MeasuredPair]]:
    """The pairs of each picture, by the other one."""
    result: defaultdict[int, dict[int, MeasuredPair]] = defaultdict(dict)
    for pair in pairs:
        result[pair.edge.a][pair.edge.b] = result[pair.edge.b][pair.edge.a] = pair
    return dict(result)


def surest_first(pairs: Sequence[MeasuredPair], support: Mapping[Numbers, float]) -> list[MeasuredPair]:
    """Pictures taken one after the other first, then pairs whose colours differ no more than in the better pairs of
    both pictures, no more than twice as much, and so on, of these the ones with most support, see `pair_support`, of
    equals those with most features."""
    usual = {number: _better_colors(partners.values()) for number, partners in by_picture(pairs).items()}

    def sureness(pair: MeasuredPair) -> tuple[bool, int, float, float]:
        color_rank = min(int(pair.other_colors / min(usual[pair.edge.a], usual[pair.edge.b])), LAST_RANK)
        return pair.is_next, -color_rank, support[pair.ends], pair.weight

    return sorted(pairs, key=lambda pair: (sureness(pair), pair.edge.a, pair.edge.b), reverse=True)


def is_sure(ties: Sequence[MeasuredPair]) -> bool:
    """Whether ties that agree, the surest first, are enough to believe them."""
    return len(ties) > 1 or any(tie.is_next or tie.n_features >= ALONE_FEATURES for tie in ties)


def _better_colors(pairs: Iterable[MeasuredPair]) -> float:
    """What share of colours differs in the better pairs of a picture, the best quarter: those of its place, as in a
    place that looks alike something has another colour."""
    return max(float(np.quantile([pair.other_colors for pair in pairs], BETTER)), LEAST_COLORS)
