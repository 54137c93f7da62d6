"""Pair support: how far triangles of pictures bear a pair out, or say that it is a look-alike.

Of three pictures of which each two were registered, motions lead back to where they began where all show one place, but
also where they show two that have one shape. Colours tell these apart: two pairs of a triangle may each pass for one
place, where little is to be seen; if the third then has other colours, one of the two shows another place. No pair
alone, however well it fits, says as much as all triangles that it is part of.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.view_checks.usual_colors import UsualColors
from slam.se3 import angle_deg, length_m
from slam.sparse.measured_pair import MeasuredPair, Numbers, by_picture

LOOP_M, LOOP_DEG = 0.1, 3.0  # three motions round a triangle of pictures that err by more are not all right
SAME, OTHER = 1.0, -2.0  # what colours say for one place at most, and against it
LEAST_COLORS = 1e-3  # times what is usual; less is noise


def pair_support(pairs: Sequence[MeasuredPair], usual_colors: UsualColors) -> dict[Numbers, float]:
    """What supports each pair, by its ends: its own colours, and those of all triangles that it is part of. Some 4 bear
    a pair of one place out; those of look-alikes have -3 to -20, where many pictures show both places.

    Args:
        pairs: all that were measured.
        usual_colors: what share of colours differs between pictures so far apart.
    """
    table, likeness = by_picture(pairs), _likeness(pairs, usual_colors)
    return {pair.ends: likeness[pair.ends] + sum(_triangles(pair, table, likeness)) for pair in pairs}


def _likeness(pairs: Sequence[MeasuredPair], usual_colors: UsualColors) -> dict[Numbers, float]:
    """Whether colours say that both pictures of a pair show one place: nothing at twice as many other ones as usual,
    and by so many doublings more or less."""
    usual = usual_colors.at([pair.separation for pair in pairs])
    excess = np.array([pair.other_colors for pair in pairs]) / usual
    told = np.clip(1 - np.log2(np.maximum(excess, LEAST_COLORS)), OTHER, SAME).tolist()
    return {pair.ends: one for pair, one in zip(pairs, told, strict=True)}


def _triangles(
    pair: MeasuredPair, table: Mapping[int, Mapping[int, MeasuredPair]], likeness: Mapping[Numbers, float]
) -> Iterator[float]:
    """What each triangle says of a pair."""
    a, b = pair.ends
    for c in table[a].keys() & table[b].keys():
        from_a, from_b = table[a][c], table[b][c]
        if not _closes(pair.edge.a_from_b, from_b.motion(b), from_a.motion(a)):
            yield -1.0
            continue
        worse, better = sorted((likeness[from_a.ends], likeness[from_b.ends]))
        yield worse if better > 0 else 0.0  # where both are other places, they may be the same one


def _closes(a_from_b: Float64Array, b_from_c: Float64Array, a_from_c: Float64Array) -> bool:
    off = inverse(a_from_c) @ a_from_b @ b_from_c
    return length_m(off) <= LOOP_M and angle_deg(off) <= LOOP_DEG
