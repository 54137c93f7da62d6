"""Recall of true instances by the number of frames that show them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

# First number of views of each bin.
_FIRST = (0, 1, 3, 6, 11, 21, 51, 101, 201)


class ViewedInstance(NamedTuple):
    """How many frames show a true instance, and whether a prediction matched it at IoU 0.5."""

    views: int
    matched: bool


def recall_by_views(instances: Iterable[ViewedInstance], n_frames: int) -> list[dict[str, Any]]:
    """`views` [lowest, highest], `n` and `recall50` of the true instances of each bin that has any.

    Args:
        instances: the true instances that are evaluated.
        n_frames: frames that were looked at, the highest number of views there can be.
    """
    known = list(instances)
    highest = [min(after - 1, n_frames) for after in _FIRST[1:]] + [n_frames]
    bins = []
    for low, high in zip(_FIRST, highest, strict=True):
        hits = [instance.matched for instance in known if low <= instance.views <= high]
        if hits:
            bins.append({"views": [low, high], "n": len(hits), "recall50": sum(hits) / len(hits)})
    return bins
