"""Pictures of two rooms that look alike and lie on each other are told, and those of one place are left together."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse import csr_array

from slam.backend.pose_graph import PoseEdge
from slam.backend.view_checks.color_check import ColorDifference
from slam.config import SlamConfig
from slam.sparse.known_pairs import KnownPairs
from slam.sparse.measured_pair import MeasuredPair
from slam.sparse.placement import parts as parts_module
from slam.sparse.placement.color_cut import _sides, color_cut
from slam.sparse.placement.parts import Parts

N = 24


def at(x_m: float):
    pose = np.eye(4)
    pose[0, 3] = x_m
    return pose


POSES = {n: at(0.1 * (n // 2)) for n in range(N)}
"""Pictures one beside the other, two at each place."""


def told(share, n_readings=2000):
    """Pictures of which a pair has a share of other colours, where that is not None, once it is asked for."""

    def pair(a, b, a_from_b):
        assert a < b
        assert a_from_b[0, 3] == pytest.approx(POSES[b][0, 3] - POSES[a][0, 3])

        def color_difference(_):
            of = share(a, b)
            return None if of is None else ColorDifference(of, n_readings)

        return SimpleNamespace(separation=float(a_from_b[0, 3]), color_difference=color_difference)

    return SimpleNamespace(pair=pair)


def cut(share, poses=POSES, **options):
    return color_cut(told(share, **options), poses, SlamConfig())


@pytest.fixture
def noise(rng):
    """Shares of other colours of one place: hardly any in most pairs, some in one of ten."""
    return np.where(rng.uniform(size=(N, N)) < 0.9, 0.0, rng.uniform(0, 0.002, (N, N)))


@pytest.mark.parametrize("other", [{3, 6, 7, 10, 13, 16, 20}, {*range(0, N - 2, 2)}], ids=["some", "half"])
def test_rooms_that_lie_on_each_other_are_told_by_a_little_in_most_pairs_across(other, noise, rng):
    """By 0.8 % at the median, where any one pair of one place may have more."""
    across = rng.lognormal(np.log(0.008), 1, (N, N))
    assert cut(lambda a, b: (across if (a in other) != (b in other) else noise)[a, b]) == other


def test_one_place_is_one_however_clean_its_colours_are(noise):
    assert cut(lambda a, b: noise[a, b]) == set()
    assert cut(lambda a, b: 0.0) == set()
    assert cut(lambda a, b: None) == set()


def test_one_place_is_one_however_much_exposure_changes(rng):
    """As in a kitchen: 3 % at the median, twice as much or half in a third of the pairs."""
    shares = rng.lognormal(np.log(0.03), 0.7, (N, N))
    assert cut(lambda a, b: shares[a, b]) == set()


def test_where_colours_of_one_place_differ_a_few_pairs_say_so_and_the_others_are_not_compared(rng):
    shares, compared = rng.lognormal(np.log(0.03), 0.7, (N, N)), list[tuple[int, int]]()
    assert cut(lambda a, b: compared.append((a, b)) or shares[a, b]) == set()
    compared_clean = list[tuple[int, int]]()
    assert cut(lambda a, b: compared_clean.append((a, b)) or 0.0) == set()
    assert 0 < len(compared) < len(compared_clean) / 4


def test_rooms_beside_each_other_are_one_place_though_the_wall_between_has_two_colours(noise):
    def share(a, b):
        if (a < N // 2) == (b < N // 2):
            return noise[a, b]
        return 0.05 if b - a < 4 else None  # else they share nothing

    assert cut(share) == set()


def test_pictures_that_lie_roughly_are_of_the_same_place(noise):
    """They differ from all round about, and from each other as much."""
    rough = {3, 6, 7, 10, 13, 16, 20}
    assert cut(lambda a, b: 0.01 if {a, b} & rough else noise[a, b]) == set()


def test_a_few_readings_say_little(noise):
    other = {3, 6, 7, 10, 13, 16, 20}

    def share(a, b):
        return 0.01 if (a in other) != (b in other) else noise[a, b]

    assert cut(share) == other
    assert cut(share, n_readings=60) == set()


def test_few_pictures_are_one_place():
    assert cut(lambda a, b: 0.1 * (a == 0), {n: POSES[n] for n in range(3)}) == set()


def test_sides_are_the_best_of_all_there_are(rng):
    for _ in range(20):
        n = int(rng.integers(4, 11))
        planted = np.where(rng.uniform(size=n) < 0.4, 1, -1)
        weights = np.triu(rng.normal(0, 1, (n, n)) - 1.5 * np.outer(planted, planted), 1)
        weights += weights.T
        every = np.array([*product([1, -1], repeat=n)])
        least = np.einsum("si,ij,sj->s", every, weights, every).min()
        sides = _sides(csr_array(weights))
        assert sides @ weights @ sides == pytest.approx(least)


def test_what_tied_two_places_is_forgotten_and_they_are_parted(monkeypatch):
    """Four pictures in a row, of which the last two show another place."""
    ends = [(0, 1), (1, 2), (2, 3)]
    pairs = [MeasuredPair(PoseEdge(a, b, at(0.1), 1e6 * np.eye(6)), 40, 0.5) for a, b in ends]
    keyframes = [None] * 4
    known = KnownPairs(keyframes, pairs, SlamConfig())
    parts = Parts(keyframes, known, SlamConfig())
    for n in (1, 2, 3):
        parts._join(0, n, at(0.1 * n))
    found = iter([{2, 3}])
    monkeypatch.setattr(parts_module, "color_cut", lambda *_: next(found))
    assert parts.part_look_alikes()
    assert parts.members == {0: [0, 1], 2: [2, 3]}
    assert sorted(pair.ends for pair in known) == [(0, 1), (2, 3)]
    monkeypatch.setattr(parts_module, "color_cut", lambda *_: set())
    assert not parts.part_look_alikes()
