"""What moves along with an odometry chain, and how far keyframes are from what ties it."""

from __future__ import annotations

import numpy as np

from slam.backend.submaps.chain_ties import hanging_on, way_to_ties


def hanging(chain, chains, *ends):
    return hanging_on(chain, np.array(chains), np.array(ends, np.int64).reshape(-1, 2)).tolist()


def test_a_chain_moves_with_what_was_tied_to_it_alone():
    chains = [0, 0, 1, 1, 2, 2]
    assert hanging(1, chains, (0, 1), (1, 2), (2, 3), (3, 4), (4, 5)) == [2, 3, 4, 5]


def test_a_later_chain_that_is_tied_to_the_rest_as_well_stays():
    chains = [0, 0, 1, 1, 2, 2]
    assert hanging(1, chains, (0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (0, 5)) == [2, 3]


def test_ties_of_the_chain_itself_to_earlier_ones_hold_nothing():
    assert hanging(2, [0, 1, 2, 2], (0, 1), (0, 2), (1, 3), (2, 3)) == [2, 3]
    assert hanging(2, [0, 1, 2, 2]) == [2, 3]


def test_the_way_to_a_tie_goes_along_edges():
    """Five keyframes round a square of one metre, the last one metre from the first but not joined with it."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [5, 5, 5]], float)
    ends = np.array([(0, 1), (1, 2), (2, 3), (1, 2), (2, 1)])
    assert way_to_ties(np.array([(0, 4)]), corners, ends).tolist() == [0, 1, 2, 3, 0]


def test_the_nearest_tie_counts_and_what_nothing_leads_to_is_infinitely_far():
    places = np.array([[0, 0, 0], [2, 0, 0], [5, 0, 0], [9, 9, 9], [5, 0, 0]], float)
    ends = np.array([(0, 1), (1, 2), (2, 4)])
    np.testing.assert_allclose(way_to_ties(np.array([(0, 2)]), places, ends), [0, 2, 0, np.inf, 0], atol=1e-6)
