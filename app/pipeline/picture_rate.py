"""Pace of a recording: whether its pictures are so few and far between that they are matched all at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.settings.run_config import InputSettings
from data_tools.recordings.recorded_sequence import RecordedSequence
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import BadInput
from slam.sparse.limits import MAX_PICTURES

SPARSE_PER_S = 2.0  # pictures a second below which a camera may be anywhere from one to the next


def pictures_per_s(sequence: RgbdSequence, indices: Sequence[int]) -> float | None:
    """How many pictures a second were taken, by the median gap of recorded stamps; None where these are no times."""
    if not isinstance(sequence, RecordedSequence) or not sequence.recorded_stamps or len(indices) < 3:
        return None
    stamps = np.sort([sequence.images.stamp(index) for index in indices])
    gap_s = float(np.median(np.diff(stamps)))
    return 1 / gap_s if gap_s > 0 else None


def is_sparse(sequence: RgbdSequence, indices: Sequence[int], settings: InputSettings) -> bool:
    """Whether frames are matched all at once: as asked for, or where they are few and far between; raises BadInput
    where it was asked for and they are too many."""
    if settings.sparse is False:
        return False
    if settings.sparse is None:
        rate = pictures_per_s(sequence, indices)
        return rate is not None and rate < SPARSE_PER_S and len(indices) <= MAX_PICTURES
    if len(indices) > MAX_PICTURES:
        raise BadInput(
            f"{sequence.name}: {len(indices)} pictures are too many to be matched all at once, {MAX_PICTURES} at most: "
            "choose some with --stride, or leave --sparse out"
        )
    return True


def require_estimated(choice: str, sparse: bool | None) -> None:
    """Raise BadInput where pictures are to be matched with each other and poses are not estimated from them alone."""
    if sparse:
        raise BadInput(f"--sparse estimates poses from images alone, --poses {choice} does not: leave one of them out")
