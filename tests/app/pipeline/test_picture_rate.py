"""Which recordings are matched all at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from app.pipeline.picture_rate import is_sparse, pictures_per_s, require_estimated
from app.settings.run_config import InputSettings
from data_tools.recordings.recorded_sequence import RecordedSequence
from razer.errors import BadInput
from slam.sparse.limits import MAX_PICTURES


@dataclass(frozen=True)
class Stamps:
    """Images of which only the stamps matter."""

    seconds: tuple[float, ...]

    def __len__(self):
        return len(self.seconds)

    def stamp(self, index):
        return self.seconds[index]


def recording(seconds, recorded=True):
    return RecordedSequence("clip", Stamps(tuple(seconds)), None, 1000.0, recorded_stamps=recorded)


SLOW, FAST = np.arange(20) * 0.8, np.arange(20) / 30


@pytest.mark.parametrize(
    ("seconds", "recorded", "every", "expected"),
    [
        (SLOW, True, 1, True),
        (SLOW[::-1], True, 1, True),
        (FAST, True, 1, False),
        (FAST, True, 6, False),
        (np.arange(100) / 30, True, 20, True),
        (SLOW, False, 1, False),
        ([0.0, 9.0], True, 1, False),
        (np.zeros(20), True, 1, False),
    ],
    ids=["slow", "slow, backwards", "video", "every sixth", "every twentieth", "no clock", "two", "one moment"],
)
def test_pictures_are_sparse_by_the_pace_of_recorded_stamps(seconds, recorded, every, expected):
    clip = recording(seconds, recorded)
    assert is_sparse(clip, range(0, len(clip), every), InputSettings()) == expected


def test_what_is_asked_for_counts():
    assert is_sparse(recording(FAST), range(20), InputSettings(sparse=True))
    assert not is_sparse(recording(SLOW), range(20), InputSettings(sparse=False))
    assert pictures_per_s(recording(SLOW), range(20)) == pytest.approx(1.25)


def test_too_many_pictures_are_refused_if_asked_for_and_followed_if_not():
    many = recording(np.arange(MAX_PICTURES + 1) * 1.0)
    assert not is_sparse(many, range(len(many)), InputSettings())
    with pytest.raises(BadInput, match="1501 pictures are too many"):
        is_sparse(many, range(len(many)), InputSettings(sparse=True))


@pytest.mark.parametrize("choice", ["given", "refine"])
def test_given_poses_are_not_matched(choice):
    require_estimated(choice, None)
    with pytest.raises(BadInput, match=f"--poses {choice} does not"):
        require_estimated(choice, True)
