"""Pair support: how far others bear a pair of pictures out, or say that it is a look-alike.

Of three pictures of which each two were registered, motions lead back to where they began where all show one place, but
also where they show two that have one shape. Colours tell these apart: two pairs of a triangle may each pass for one
place, where little is to be seen; if the third then has other colours, one of the two shows another place. So does one
of two that put pictures on each other which were not recognised. No pair alone, however well it fits, says as much as
all others that it has to do with.

A picture of what two places have in common has good pairs with both, and such pictures bear each other out. So what is
said is weighed anew (relaxation labelling, Rosenfeld, Hummel and Zucker 1976): whoever is not borne out says less.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.view_checks.usual_colors import UsualColors
from slam.se3 import angle_deg, length_m
from slam.sparse.measured_pair import MeasuredPair, Numbers, by_picture

# Three motions round a triangle of pictures that err by more are not all right. As features alone have it one motion is
# off by 4 cm and 1 degree at the median, by 13 cm and 3 degrees in one of ten.
LOOP_M, LOOP_DEG = 0.2, 6.0
SAME, OTHER = 1.0, -2.0  # what colours say for one place at most, and against it
LEAST_COLORS = 1e-3  # times what is usual; less is noise
BORNE_OUT = 4.0  # support of a pair that others believe
ROUNDS = 2  # of weighing anew

Likeness = Mapping[Numbers, float]  # by the ends of a pair, what it says for its place


class Triangle(NamedTuple):
    """The two other pairs of a triangle, by their ends, and whether the motions of all three lead back."""

    one: Numbers
    other: Numbers
    closes: bool

    def says(self, told: Likeness) -> float:
        """What it says of the pair, as its two others say so much."""
        worse, better = sorted((told[self.one], told[self.other]))
        if not self.closes:
            return -max(worse, 0.0)
        return worse if better > 0 else 0.0  # where both are other places, they may be the same one


def pair_support(
    pairs: Sequence[MeasuredPair], usual_colors: UsualColors, missing: Mapping[Numbers, Sequence[Numbers]]
) -> dict[Numbers, float]:
    """What supports each pair, by its ends: its own colours, those of all triangles that it is part of, and the pairs
    that it is at odds with. Some 4 bear a pair of one place out; those of look-alikes have -3 to -20, where many
    pictures show both places.

    Args:
        pairs: all that were measured.
        usual_colors: what share of colours differs between pictures so far apart.
        missing: with which pairs each is at odds, see `missing_pairs`.
    """
    likeness = told = _likeness(pairs, usual_colors)
    triangles = _triangles(pairs)
    support = _support(told, likeness, triangles, missing)
    for _ in range(ROUNDS):
        told = {ends: min(own, max(support[ends] / BORNE_OUT, min(own, 0.0))) for ends, own in likeness.items()}
        support = _support(told, likeness, triangles, missing)
    return support


def _support(
    told: Likeness,
    likeness: Likeness,
    triangles: Mapping[Numbers, Sequence[Triangle]],
    missing: Mapping[Numbers, Sequence[Numbers]],
) -> dict[Numbers, float]:
    return {
        ends: own
        + sum(triangle.says(told) for triangle in triangles[ends])
        - sum(max(told[other], 0.0) for other in missing.get(ends, ()))
        for ends, own in likeness.items()
    }


def _likeness(pairs: Sequence[MeasuredPair], usual_colors: UsualColors) -> dict[Numbers, float]:
    """Whether colours say that both pictures of a pair show one place: nothing at twice as many other ones as usual,
    and by so many doublings more or less."""
    usual = usual_colors.at([pair.separation for pair in pairs])
    excess = np.array([pair.other_colors for pair in pairs]) / usual
    told = np.clip(1 - np.log2(np.maximum(excess, LEAST_COLORS)), OTHER, SAME).tolist()
    return {pair.ends: one for pair, one in zip(pairs, told, strict=True)}


def _triangles(pairs: Sequence[MeasuredPair]) -> dict[Numbers, list[Triangle]]:
    """The triangles that each pair is part of, by its ends."""
    table, result = by_picture(pairs), dict[Numbers, list[Triangle]]()
    for pair in pairs:
        a, b = pair.ends
        thirds = ((table[a][c], table[b][c]) for c in table[a].keys() & table[b].keys())
        result[a, b] = [
            Triangle(to_a.ends, to_b.ends, _closes(pair.edge.a_from_b, to_b.motion(b), to_a.motion(a)))
            for to_a, to_b in thirds
        ]
    return result


def _closes(a_from_b: Float64Array, b_from_c: Float64Array, a_from_c: Float64Array) -> bool:
    off = inverse(a_from_c) @ a_from_b @ b_from_c
    return length_m(off) <= LOOP_M and angle_deg(off) <= LOOP_DEG
