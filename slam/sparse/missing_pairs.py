"""Missing pairs: pictures that would show the same if two pairs with a third were both true, and were not recognised.

Of places that look alike a picture may fit both, with the same colours in whatever little it shows. Then it puts
pictures of both on each other, and of these not all pass for one place: one of its two pairs is false.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Sequence

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.view_overlap import overlap_of, reading_points, separation
from slam.frontend.keyframes import Keyframes
from slam.sparse.measured_pair import MeasuredPair, Numbers, by_picture

# Of pairs of one place that share this much both ways, so little apart, 95 in 100 are recognised.
LEAST_SHARED, MOST_APART = 0.35, 0.8


def missing_pairs(
    keyframes: Keyframes, pairs: Sequence[MeasuredPair], unrecognised: Collection[Numbers], max_depth_m: float
) -> dict[Numbers, list[Numbers]]:
    """The pairs with which each pair is at odds, by their ends.

    Args:
        keyframes: the pictures.
        pairs: all that were measured.
        unrecognised: the pairs that were compared in vain.
        max_depth_m: of readings that count.
    """
    table = by_picture(pairs)
    points = {number: reading_points(keyframes[number].view, max_depth_m) for number in table} if unrecognised else {}

    def show_the_same(a: int, b: int, a_from_b: Float64Array) -> bool:
        views = keyframes[a].view, keyframes[b].view
        if separation(*views, a_from_b) > MOST_APART or overlap_of(points[b], views[0], a_from_b) < LEAST_SHARED:
            return False
        return overlap_of(points[a], views[1], inverse(a_from_b)) >= LEAST_SHARED

    missing = defaultdict[Numbers, list[Numbers]](list)
    for a, b in sorted(unrecognised):
        for c in sorted(table.get(a, {}).keys() & table.get(b, {}).keys()):
            to_a, to_b = table[a][c], table[b][c]
            if show_the_same(a, b, to_a.motion(a) @ to_b.motion(c)):
                missing[to_a.ends].append(to_b.ends)
                missing[to_b.ends].append(to_a.ends)
    return dict(missing)
