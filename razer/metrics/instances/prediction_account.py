"""Account of predictions: what became of each, regardless of class and at IoU 0.5."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from razer.arrays import Int64Array
from razer.metrics.instances.match_summary import MatchSummary
from razer.metrics.instances.matching import Overlaps


class Ground(IntEnum):
    """What a vertex of a prediction lies on: nothing true; stuff, such as walls; other truth that does not count
    (unobserved, or of unlisted classes); a true thing that is evaluated."""

    NOTHING = 0
    STUFF = 1
    UNCOUNTED = 2
    THING = 3


class PredictionAccount(NamedTuple):
    """Ids of predictions, each in one list. matched: a true instance of its own; pieces: most of it lies in a true
    instance that another one matched (duplicates); parts: on true instances, but part of a missed one or of several;
    uncounted: most of it on stuff or on truth that does not count; invented: most of it on nothing true, or, where it
    is named as a thing, on stuff and nothing."""

    matched: tuple[int, ...]
    pieces: tuple[int, ...]
    parts: tuple[int, ...]
    uncounted: tuple[int, ...]
    invented: tuple[int, ...]

    @property
    def wrong(self) -> tuple[int, ...]:
        """Those that count as false: all but the matched and the uncounted."""
        return (*self.pieces, *self.parts, *self.invented)


def account_for(
    overlaps: Overlaps,
    summary: MatchSummary,
    grounds: Mapping[int, Int64Array],
    things: Collection[int],
    min_region: int,
) -> PredictionAccount:
    """Sort predictions by what they lie on.

    Args:
        overlaps: vertices of the truth that instances share.
        summary: matches and duplicates among them.
        grounds: of each prediction the number of its own vertices (4,) on each `Ground`.
        things: ids of predictions that are named as things.
        min_region: vertices of the smallest prediction that counts.
    """
    matched = {match.predicted for match in summary.matches}
    large = set(overlaps.predicted_ids[overlaps.predicted_sizes >= min_region].tolist())
    lists: dict[str, list[int]] = {name: [] for name in PredictionAccount._fields}
    for number, counts in sorted(grounds.items()):
        invented = _is_invented(counts, number in things)
        if number in matched:
            lists["matched"].append(number)
        elif invented and int(counts.sum()) >= min_region:
            lists["invented"].append(number)
        elif number in large:
            lists[_kind(number, counts, summary)].append(number)
    return PredictionAccount(**{name: tuple(ids) for name, ids in lists.items()})


def _is_invented(counts: Int64Array, is_thing: bool) -> bool:
    nothing = counts[Ground.NOTHING] + (counts[Ground.STUFF] if is_thing else 0)
    return bool(2 * nothing > counts.sum())


def _kind(number: int, counts: Int64Array, summary: MatchSummary) -> str:
    if number in summary.duplicates:
        return "pieces"
    # What lies on nothing is no reason to count what else lies on walls.
    return "uncounted" if counts[Ground.STUFF] + counts[Ground.UNCOUNTED] > counts[Ground.THING] else "parts"


def count_grounds(ids: Int64Array, grounds: Int64Array) -> dict[int, Int64Array]:
    """Of each id > 0 of some vertices (N,) how many lie on each `Ground` (N,): (4,)."""
    distinct, row = np.unique(ids, return_inverse=True)
    counts = np.bincount(row * len(Ground) + grounds, minlength=len(distinct) * len(Ground)).reshape(-1, len(Ground))
    return {int(i): c for i, c in zip(distinct, counts, strict=True) if i > 0}
