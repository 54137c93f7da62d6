"""What other pairs say of one: hand-made triangles, and rooms of one shape, whose colours tell them apart."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from razer.geometry import inverse
from slam.backend.pose_graph import PoseEdge
from slam.backend.view_checks.usual_colors import UsualColors
from slam.se3 import exp_se3
from slam.sparse.measured_pair import MeasuredPair
from slam.sparse.pair_support import Triangle, pair_support

USUAL = UsualColors(np.full(24, 0.5), np.full(24, 0.01))
LIKE, DOUBTFUL, OTHER = 0.01, 0.02, 0.08  # shares of other colours that say 1, 0 and -2
INFORMATION = np.eye(6)


def pair(a, b, other_colors=LIKE, a_from_b=None, n_features=100):
    motion = np.eye(4) if a_from_b is None else a_from_b
    return MeasuredPair(PoseEdge(a, b, motion, INFORMATION), n_features, 0.6, other_colors, 0.5)


def support(*pairs, missing=None):
    return pair_support(pairs, USUAL, missing or {})


@pytest.mark.parametrize(("colors", "told"), [(0.0, 1), (LIKE, 1), (DOUBTFUL, 0), (0.04, -1), (OTHER, -2), (0.9, -2)])
def test_without_a_triangle_a_pair_has_what_its_colours_say(colors, told):
    assert support(pair(0, 1, colors), pair(2, 3)) == pytest.approx({(0, 1): told, (2, 3): 1})


@pytest.mark.parametrize(
    ("one", "other", "says"),
    [
        (1, 1, 1),  # all three show one place
        (1, -2, -2),  # the third is in the place of one of them, and not in that of the other
        (-2, 1, -2),
        (-2, -2, 0),  # the third lies elsewhere, and both may lie together
        (0, -2, 0),  # as it may where nobody believes that it lies with one of them
        (1, 0, 0),
    ],
)
def test_a_triangle_says_what_the_less_alike_of_the_two_other_pairs_does(one, other, says):
    assert Triangle((0, 2), (1, 2), closes=True).says({(0, 2): one, (1, 2): other}) == says


@pytest.mark.parametrize(("one", "other", "says"), [(1, 1, -1), (0.5, 1, -0.5), (0, 1, 0), (-2, 1, 0), (-2, -1, 0)])
def test_a_triangle_that_does_not_close_speaks_against_a_pair_as_far_as_both_others_are_believed(one, other, says):
    assert Triangle((0, 2), (1, 2), closes=False).says({(0, 2): one, (1, 2): other}) == says


def test_whoever_is_borne_out_by_little_says_less():
    """Each of three pairs has 1 of itself, and 1, 1/2 and 3/8 of the triangle, as 4 would bear it out."""
    assert support(pair(0, 1), pair(0, 2), pair(1, 2)) == pytest.approx(dict.fromkeys([(0, 1), (0, 2), (1, 2)], 1.375))
    aside = exp_se3(np.array([0, 0, 0, 0.3, 0, 0]))
    told = support(pair(0, 1, a_from_b=aside), pair(0, 2), pair(1, 2))
    assert told == pytest.approx(dict.fromkeys(told, 0.75))  # 1, less 1, 0 and 1/4


def test_pictures_of_what_two_rooms_have_in_common_bear_each_other_out_less_than_those_of_either():
    """0 to 4 show one room, 5 to 9 the other; 10 and 11 show what may be in any, and go with all others. By colours
    alone all others would bear out that these two show one place."""
    pairs = [pair(a, b, LIKE if (a < 5) == (b < 5) or b >= 10 else OTHER) for a, b in combinations(range(12), 2)]
    told = support(*pairs)
    assert told[10, 11] < min(told[a, b] for a, b in combinations(range(5), 2))
    assert max(told[a, 10] for a in range(10)) < 1


def test_pairs_that_put_pictures_on_each_other_which_are_not_alike_speak_against_each_other():
    """Picture 5 goes with two places, of one of which more pictures show it. None of the other was recognised there."""
    places = [pair(a, b) for a, b in [*combinations(range(4), 2), *combinations((6, 7, 8), 2)]]
    here, there = [pair(n, 5) for n in range(4)], [pair(5, n) for n in (6, 7)]
    missing = {one.ends: [two.ends for two in there] for one in here} | {
        two.ends: [one.ends for one in here] for two in there
    }
    told, without = support(*places, *here, *there, missing=missing), support(*places, *here, *there)
    assert all(told[one.ends] < without[one.ends] for one in (*here, *there))
    assert max(told[two.ends] for two in there) < min(told[one.ends] for one in here)
    assert all(told[one.ends] == pytest.approx(without[one.ends], abs=1.0) for one in places)


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
