"""Votes of cells: a dictionary that counts does the same, slowly."""

from __future__ import annotations

import numpy as np
import pytest

from razer.tracking.parts.cell_votes import CellVotes, lattice_keys

SIZE_M = 0.02


def keys_of(places: list[list[int]]) -> np.ndarray:
    return np.sort(lattice_keys(np.array(places, np.int32).reshape(-1, 3)))


@pytest.mark.parametrize("seed", range(3))
def test_votes_count_as_a_dictionary_does(seed: int) -> None:
    rng = np.random.default_rng(seed)
    votes, counted, viewed = CellVotes(), {}, {}
    for _ in range(6):
        observed = np.unique(lattice_keys(rng.integers(-20, 20, (300, 3))))
        in_mask = np.sort(rng.choice(observed, 40, replace=False))
        weight = float(rng.choice([0.25, 1.0]))
        blocks = {key >> 12 for key in in_mask.tolist()}
        votes.add(in_mask, observed, weight)
        for key in observed.tolist():
            if key in viewed or key >> 12 in blocks:
                viewed[key] = viewed.get(key, 0) + weight
        for key in in_mask.tolist():
            counted[key] = counted.get(key, 0) + weight
    assert votes.keys.tolist() == sorted(viewed)
    np.testing.assert_allclose(votes.views, [viewed[k] for k in sorted(viewed)])
    np.testing.assert_allclose(votes.votes, [counted.get(k, 0) for k in sorted(viewed)])
    assert votes.own.tolist() == sorted(k for k in counted if 2 * counted[k] >= viewed[k])
    assert votes.n_known(observed) == len(set(observed.tolist()) & viewed.keys())


def test_points_are_of_the_part_where_most_of_the_cells_around_are() -> None:
    """A row of ten cells, of which the first five are of the part."""
    row = [[x, 0, 0] for x in range(10)]
    votes = CellVotes()
    votes.add(keys_of(row[:5]), keys_of(row), 1.0)
    points = np.array([[1.0, 0, 0], [4.0, 0, 0], [4.3, 0, 0], [4.7, 0, 0], [5.0, 0, 0], [2, 3, 0]]) * SIZE_M
    assert votes.hold(points, SIZE_M).tolist() == [True, True, True, False, False, False]
    low, high = votes.bounds_m(SIZE_M)
    assert (low <= points[0]).all()
    assert (points[4] <= high).all()
    assert not CellVotes().hold(points, SIZE_M).any()


def test_doubles_add_their_votes() -> None:
    one, other = CellVotes(), CellVotes()
    both = keys_of([[0, 0, 0], [1, 0, 0]])
    one.add(both[:1], both, 1.0)
    other.add(both[1:], both, 2.0)
    one.absorb(other)
    assert (one.votes.tolist(), one.views.tolist()) == ([1, 2], [3, 3])
    assert one.own.tolist() == keys_of([[1, 0, 0]]).tolist()
