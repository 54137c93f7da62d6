"""What triangles of pictures say of a pair: hand-made ones, and rooms of one shape, whose colours tell them apart."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from razer.geometry import inverse
from slam.backend.pose_graph import PoseEdge
from slam.backend.view_checks.usual_colors import UsualColors
from slam.se3 import exp_se3
from slam.sparse.measured_pair import MeasuredPair
from slam.sparse.pair_support import pair_support

USUAL = UsualColors(np.full(24, 0.5), np.full(24, 0.01))
LIKE, DOUBTFUL, OTHER = 0.01, 0.02, 0.08  # shares of other colours that say 1, 0 and -2
INFORMATION = np.eye(6)


def pair(a, b, other_colors=LIKE, a_from_b=None, n_features=100):
    motion = np.eye(4) if a_from_b is None else a_from_b
    return MeasuredPair(PoseEdge(a, b, motion, INFORMATION), n_features, 0.6, other_colors, 0.5)


def support(*pairs):
    return pair_support(pairs, USUAL)


@pytest.mark.parametrize(("colors", "told"), [(0.0, 1), (LIKE, 1), (DOUBTFUL, 0), (0.04, -1), (OTHER, -2), (0.9, -2)])
def test_without_a_triangle_a_pair_has_what_its_colours_say(colors, told):
    assert support(pair(0, 1, colors), pair(2, 3)) == pytest.approx({(0, 1): told, (2, 3): 1})


@pytest.mark.parametrize(
    ("to_a", "to_b", "told"),
    [
        (LIKE, LIKE, 1),  # all three show one place
        (LIKE, OTHER, -2),  # the third is in the place of one of them, and not in that of the other
        (OTHER, LIKE, -2),
        (OTHER, OTHER, 0),  # the third lies elsewhere, and both may lie together
        (LIKE, DOUBTFUL, 0),
        (DOUBTFUL, OTHER, 0),
    ],
)
def test_a_triangle_says_what_the_less_alike_of_the_two_other_pairs_does(to_a, to_b, told):
    pairs = [pair(0, 1), pair(0, 2, to_a), pair(1, 2, to_b)]
    assert support(*pairs)[0, 1] == pytest.approx(1 + told)


def test_a_triangle_that_does_not_close_says_that_one_of_its_pairs_is_false():
    aside = exp_se3(np.array([0, 0, 0, 0.3, 0, 0]))
    assert support(pair(0, 1, a_from_b=aside), pair(0, 2), pair(1, 2)) == pytest.approx(
        {(0, 1): 0, (0, 2): 0, (1, 2): 0}
    )


def test_it_does_not_matter_in_which_direction_pairs_were_measured(rng):
    poses = [exp_se3(rng.normal(0, 0.5, 6)) for _ in range(4)]
    colors = dict(zip(combinations(range(4), 2), (LIKE, OTHER, DOUBTFUL, LIKE, OTHER, LIKE), strict=True))
    pairs = [pair(a, b, c, inverse(poses[a]) @ poses[b]) for (a, b), c in colors.items()]
    turned = [pair(b, a, c, inverse(poses[b]) @ poses[a]) for (a, b), c in colors.items()]
    here, there = support(*pairs), support(*turned)
    assert {(b, a): told for (a, b), told in here.items()} == pytest.approx(there)


def test_of_two_rooms_furnished_alike_pairs_that_look_the_same_are_told_by_all_others():
    """Pictures 0 to 4 show one room, 5 to 9 the other, from the same places. 2 and 7 look at the one wall that is the
    same in both, and no more of their colours differ than anywhere; whoever looks at the rest tells."""
    pairs = []
    for a, b in combinations(range(10), 2):
        is_same_room, shows_same = (a < 5) == (b < 5), {a, b} == {2, 7}
        pairs.append(pair(a, b, LIKE if is_same_room or shows_same else OTHER, n_features=50 if is_same_room else 400))
    told = support(*pairs)
    within = [told[a, b] for a, b in told if (a < 5) == (b < 5)]
    assert min(within) >= 2 > -10 > told[2, 7]
