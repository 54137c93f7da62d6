"""What a view of an unanchored submap is compared with next."""

from __future__ import annotations

import numpy as np
import pytest

from slam.backend.submaps.submap_search import SubmapSearch
from slam.config import SlamConfig

LED_TO, ALIKE = (7, [np.eye(4)]), [(1, []), (2, []), (3, [])]


@pytest.fixture
def search(monkeypatch):
    monkeypatch.setattr(SubmapSearch, "candidates", lambda _, places, shortlist: places)
    return SubmapSearch(None, None, None, None, SlamConfig())


def test_places_that_look_alike_are_asked_in_turn_and_those_that_hypotheses_lead_to_always(search):
    asked = [[number for number, _ in search.next_candidates([LED_TO, *ALIKE])] for _ in range(6)]
    assert all(numbers[0] == 7 and len(numbers) == 2 for numbers in asked)
    assert [numbers[1] for numbers in asked[3:]] == [numbers[1] for numbers in asked[:3]]
    assert {numbers[1] for numbers in asked} == {1, 2, 3}


def test_where_nothing_looks_alike_nothing_is_asked(search):
    assert search.next_candidates([]) == []
    assert search.next_candidates([LED_TO]) == [LED_TO]
