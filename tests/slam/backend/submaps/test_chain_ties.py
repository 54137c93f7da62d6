"""What moves along with an odometry chain."""

from __future__ import annotations

import numpy as np

from slam.backend.submaps.chain_ties import hanging_on


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
