"""Parts of made-up pairs: true ones tie all together, false ones nothing, whoever is surer of itself."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from razer.geometry import inverse
from slam.backend.pose_graph import PoseEdge
from slam.backend.view_checks.usual_colors import UsualColors
from slam.config import SlamConfig
from slam.se3 import angle_deg, exp_se3, length_m
from slam.sparse.known_pairs import KnownPairs, as_it_is
from slam.sparse.measured_pair import MeasuredPair, surest_first
from slam.sparse.pair_support import pair_support
from slam.sparse.placement.parts import Parts

N = 14
INFORMATION = np.diag([1e6] * 6)


class Places(Parts):
    """Parts of pictures whose space nothing contradicts, as there are none."""

    def _is_contradicted(self, home, away, home_from_away):
        return False


def pair(a, b, a_from_b, n_features=100):
    return MeasuredPair(PoseEdge(a, b, a_from_b, INFORMATION), n_features, 0.6)


@pytest.fixture
def ring(rng):
    """True poses once round a table, looking inwards."""
    angles = np.linspace(0, 2 * np.pi, N, endpoint=False)
    return [exp_se3(np.array([0, 0, angle, 0, 0, 0])) @ exp_se3(np.array([0.0, 0, 0, 1.5, 0, 0])) for angle in angles]


@pytest.fixture
def true_pairs(ring, rng):
    """Each picture with the two that follow it, off by millimetres."""
    ends = [tuple(sorted((n, (n + step) % N))) for n in range(N) for step in (1, 2)]
    return [
        pair(a, b, inverse(ring[a]) @ ring[b] @ exp_se3(rng.normal(0, 0.003, 6)), int(rng.integers(45, 90)))
        for a, b in ends
    ]


def parts_of(kind, pairs, n=N, register=as_it_is):
    keyframes, config = [SimpleNamespace(view=SimpleNamespace(stamp=float(i))) for i in range(n)], SlamConfig()
    return kind(keyframes, KnownPairs(keyframes, pairs, config, register=register), config)


def grown(pairs, n=N, register=as_it_is):
    parts = parts_of(Places, pairs, n, register)
    parts.grow()
    return parts


def assert_true(parts, ring, numbers):
    for n in numbers:
        first = numbers[0]
        off = inverse(inverse(ring[first]) @ ring[n]) @ inverse(parts.poses[first]) @ parts.poses[n]
        assert length_m(off) < 0.06
        assert angle_deg(off) < 3


def test_true_pairs_are_one_part_at_their_poses(ring, true_pairs):
    parts = grown(true_pairs)
    assert sorted(parts.members[parts.part_of[0]]) == list(range(N))
    assert_true(parts, ring, list(range(N)))
    assert len(parts.agreeing(parts.part_of[0])) == len(true_pairs)


def test_false_pairs_that_are_surer_of_themselves_tie_nothing(ring, true_pairs, rng):
    false = [
        pair(a, b, exp_se3(rng.normal(0, 0.7, 6)), 500)
        for a, b in [(0, 7), (1, 8), (2, 9), (3, 10), (4, 12), (5, 11), (0, 5), (6, 13)]
    ]
    parts = grown([*false, *true_pairs])
    assert len(parts.members) == 1
    assert_true(parts, ring, list(range(N)))
    assert {p.n_features for p in parts.agreeing(parts.part_of[0])}.isdisjoint({500})


def test_the_order_of_pairs_changes_nothing(true_pairs, rng):
    one, other = grown(true_pairs), grown([true_pairs[n] for n in rng.permutation(len(true_pairs))])
    for n in range(N):
        here, there = (inverse(parts.poses[0]) @ parts.poses[n] for parts in (one, other))
        np.testing.assert_allclose(here, there, atol=1e-6)


def halves(ring):
    """Two halves of the ring, in each of which every picture was measured against every other."""
    ends = [(a, b) for a in range(N) for b in range(a + 1, N) if (a < 7) == (b < 7)]
    return [pair(a, b, inverse(ring[a]) @ ring[b]) for a, b in ends]


HERE, THERE = [(0, 13), (1, 13), (1, 12)], [(2, 9), (3, 9), (3, 10)]


def ties(ring, ends, shift_m, **kinds):
    """Pairs that put one half so far from where it is."""
    moved = exp_se3(np.array([0, 0, 0, shift_m, 0, 0]))
    return [replace(pair(a, b, inverse(ring[a]) @ moved @ ring[b]), **kinds) for a, b in ends]


def test_halves_that_two_equal_groups_tie_differently_stay_apart(ring):
    """As twins of rooms do: three pairs say here, three as sure of themselves say a metre farther."""
    parts = grown([*halves(ring), *ties(ring, HERE, 0.0), *ties(ring, THERE, 1.0)])
    assert sorted(map(sorted, parts.members.values())) == [list(range(7)), list(range(7, N))]
    parts = grown([*halves(ring), *ties(ring, HERE, 0.0)])
    assert len(parts.members) == 1
    assert_true(parts, ring, list(range(N)))


class Seen(Parts):
    """Parts of pictures that contradict every place of a part but that where it is."""

    def _is_contradicted(self, home, away, home_from_away):
        return float(np.abs(home_from_away[:3, 3] - self.true_m).max()) > 0.5


@pytest.mark.parametrize("n_false", [2, 3, 12])
def test_ties_to_a_place_that_pictures_contradict_keep_nothing_apart(ring, n_false):
    """Three pairs say here, fewer, as many or far more a metre farther, where other things stand."""
    ends = [(a, b) for a in range(2, 6) for b in range(8, 12)][:n_false]
    parts = parts_of(Seen, [*halves(ring), *ties(ring, HERE, 0.0), *ties(ring, ends, 1.0)])
    for n in range(N):  # both halves at their true poses, so that the motion between them is none
        parts.poses[n] = ring[n]
    for half in (range(7), range(7, N)):
        home, *others = half
        for n in others:
            parts._join(parts.part_of[home], parts.part_of[n], np.eye(4))
    parts.true_m = np.zeros(3)
    parts.grow()
    assert len(parts.members) == 1
    assert_true(parts, ring, list(range(N)))


def test_ties_to_places_that_pictures_contradict_tie_nothing():
    class Contradicted(Parts):
        def _is_contradicted(self, home, away, home_from_away):
            return True

    parts = parts_of(Contradicted, [pair(0, 1, np.eye(4))], 2)
    parts.grow()
    assert len(parts.members) == 2


@pytest.mark.parametrize(("colors", "n_parts"), [(0.02, 1), (0.06, 2)])
def test_ties_whose_colours_differ_far_more_than_those_of_their_triangles_tie_nothing(ring, colors, n_parts):
    """Rooms furnished alike, of which one has another rug: ever so many ties agree."""
    usual = [replace(p, other_colors=0.01) for p in halves(ring)]
    ends = [(a, b) for a in range(3, 7) for b in range(7, 11)]
    parts = grown([*ties(ring, ends, 1.0, other_colors=colors), *usual])
    assert len(parts.members) == n_parts


def test_ties_that_nothing_speaks_against_join_wherever_colours_differ_as_through_a_door(ring):
    usual = [replace(p, other_colors=0.01) for p in halves(ring)]
    parts = grown([*usual, *ties(ring, [(0, 13), (6, 7)], 0.0, other_colors=0.06)])
    assert len(parts.members) == 1


@pytest.mark.parametrize(("colors", "n_parts"), [(0.05, 1), (0.08, 2)])
def test_ties_of_far_other_colours_join_nothing_where_there_are_no_triangles(ring, colors, n_parts):
    usual = [replace(p, other_colors=0.01) for p in halves(ring)]
    parts = grown([*ties(ring, [(0, 13), (6, 7)], 0.0, other_colors=colors), *usual])
    assert len(parts.members) == n_parts


def sorted_by_support(pairs):
    usual = UsualColors([p.separation for p in pairs], [p.other_colors for p in pairs])
    return surest_first(pairs, pair_support(pairs, usual, {}))


def test_pairs_whose_colours_differ_more_than_is_usual_come_last(ring, true_pairs):
    other = [replace(p, other_colors=0.05, n_features=500) for p in true_pairs[:3]]
    usual = [replace(p, other_colors=0.01) for p in true_pairs[3:]]
    assert {p.n_features for p in sorted_by_support([*other, *usual])[-3:]} == {500}
    alike = [*(replace(p, other_colors=0.015) for p in other), *usual]
    ranked = surest_first(alike, dict.fromkeys((p.ends for p in alike), 0.0))  # as likely as each other
    assert {p.n_features for p in ranked[:3]} == {500}


def test_the_way_of_the_camera_says_more_than_looks(ring):
    """Six pairs say a metre farther; a single one, of pictures taken one after the other, is the way."""
    way = ties(ring, [(6, 7)], 0.0, is_next=True, n_features=10)
    parts = grown([*halves(ring), *ties(ring, HERE + THERE, 1.0), *way])
    assert len(parts.members) == 1
    assert_true(parts, ring, list(range(N)))


@pytest.mark.parametrize(("n_features", "n_parts"), [(11, 2), (100, 1)])
def test_a_single_pair_ties_two_pictures_if_many_features_agree(n_features, n_parts):
    assert len(grown([pair(0, 1, np.eye(4), n_features)], 2).members) == n_parts


def test_pairs_that_triangles_bear_out_come_first(ring, true_pairs):
    false = pair(0, 2, exp_se3(np.array([0, 0, 0, 0, 2.0, 0])), 1000)
    others = [p for p in true_pairs if (p.edge.a, p.edge.b) != (0, 2)]
    assert sorted_by_support([false, *others])[-1] is false


def rough(pairs, rng, sigma=0.02):
    """Pairs that were not registered, off by centimetres and degrees, and what their registration says."""
    exact = {p.ends: p for p in pairs}
    off = [
        replace(
            p,
            edge=PoseEdge(*p.ends, p.edge.a_from_b @ exp_se3(rng.normal(0, sigma, 6)), 1e-3 * INFORMATION),
            is_registered=False,
        )
        for p in pairs
    ]
    return off, exact


def test_what_parts_rest_on_is_registered_and_lies_as_exactly_as_that_says(ring, true_pairs, rng):
    off, exact = rough(true_pairs, rng)
    asked = []

    def register(pair):
        asked.append(pair.ends)
        return exact[pair.ends]

    parts = grown(off, register=register)
    parts.secure()
    assert sorted(parts.members[parts.part_of[0]]) == list(range(N))
    assert len(asked) == len(set(asked)) < len(off)
    assert {p.ends for p in parts.agreeing(parts.part_of[0]) if p.is_registered} == set(asked)
    assert_true(parts, ring, list(range(N)))


def test_pairs_whose_registration_comes_to_nothing_tie_nothing(ring, rng):
    """Of two halves, all ties are rough; only of some does anything come."""
    off, exact = rough(ties(ring, HERE, 0.0), rng)
    assert len(grown([*halves(ring), *off], register=lambda _: None).members) == 2
    assert (
        len(grown([*halves(ring), *off], register=lambda p: exact[p.ends] if p.ends == HERE[0] else None).members) == 1
    )


def test_ties_that_lie_too_roughly_to_agree_do_once_they_are_registered(ring):
    """Two pairs through a door, of a dozen features each: 9 degrees off, the one to this and the other to that side."""
    exact = {p.ends: p for p in ties(ring, HERE[:2], 0.0, n_features=10)}
    turned = {
        ends: exp_se3(np.array([0, 0, sign * np.radians(9.0), 0, 0, 0]))
        for ends, sign in zip(exact, (1, -1), strict=True)
    }
    off = [
        replace(p, edge=PoseEdge(*ends, p.edge.a_from_b @ turned[ends], INFORMATION), is_registered=False)
        for ends, p in exact.items()
    ]
    assert len(grown([*halves(ring), *off]).members) == 2
    assert len(grown([*halves(ring), *off], register=lambda p: exact[p.ends]).members) == 1


def test_what_no_registration_ties_is_parted_in_the_end(ring, true_pairs):
    """Of the pairs of a picture, all of which agree, none can be registered."""
    parts = grown([replace(p, is_registered=5 not in p.ends) for p in true_pairs])
    parts.secure()
    assert len(parts.members) == 1
    parts = grown(true_pairs)
    for a, b in [p.ends for p in true_pairs if 5 in p.ends]:
        known = parts._pairs.by_number
        known[a][b] = known[b][a] = replace(known[a][b], is_registered=False)
    parts._pairs._register = lambda _: None
    parts.secure()
    assert sorted(map(sorted, parts.members.values())) == [[n for n in range(N) if n != 5], [5]]


def test_of_groups_of_ties_the_one_that_others_bear_out_counts_more(ring):
    """Five ties that hardly anything speaks for, against three that much does."""
    here, there = ties(ring, HERE, 0.0), ties(ring, [*THERE, (4, 9), (4, 10)], 1.0)
    known = KnownPairs([None] * N, [*halves(ring), *here, *there], SlamConfig())
    known._support = {p.ends: 5.0 for p in known} | {p.ends: -4.5 for p in there}
    parts = Places([None] * N, known, SlamConfig())
    parts.grow()
    assert len(parts.members) == 1
    assert_true(parts, ring, list(range(N)))
