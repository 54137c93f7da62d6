"""Which truths were found at an overlap of one half whatever their class, which twice, and which not at all."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from razer.arrays import Float64Array
from razer.metrics.instances.matching import Judgement, Overlaps, judge


class Match(NamedTuple):
    """A true and a predicted instance whose intersection over union exceeds 0.5."""

    truth: int
    predicted: int
    iou: float


class Found(NamedTuple):
    """What matched, the ids of predictions that double a truth that another one matched, the ids of missed truths."""

    matches: tuple[Match, ...]
    duplicates: tuple[int, ...]
    missed: tuple[int, ...]


def find_matches(overlaps: Overlaps, scores: Float64Array, min_region: int, strict: bool = True) -> Found:
    """Match G truths and P predictions with scores (P,) by ScanNet's rules at 0.5."""
    judgement = judge(overlaps, scores, 0.5, min_region, strict)
    matches = _matches(overlaps, judgement)
    return Found(matches, _duplicates(overlaps, matches, min_region), judgement.missed)


def _matches(overlaps: Overlaps, judgement: Judgement) -> tuple[Match, ...]:
    iou = overlaps.iou
    rows = np.searchsorted(overlaps.truth_ids, [t for t, _ in judgement.pairs])
    columns = np.searchsorted(overlaps.predicted_ids, [p for _, p in judgement.pairs])
    return tuple(Match(t, p, float(iou[r, c])) for (t, p), r, c in zip(judgement.pairs, rows, columns, strict=True))


def _duplicates(overlaps: Overlaps, matches: tuple[Match, ...], min_region: int) -> tuple[int, ...]:
    """Predictions that match nothing at 0.5 though most of their vertices lie in a truth that another one matched."""
    matched_truth = np.isin(overlaps.truth_ids, [m.truth for m in matches])
    unmatched = ~np.isin(overlaps.predicted_ids, [m.predicted for m in matches])
    inside = (2 * overlaps.counts[matched_truth] > overlaps.predicted_sizes).any(axis=0)
    chosen = unmatched & inside & (overlaps.predicted_sizes >= min_region)
    return tuple(int(p) for p in overlaps.predicted_ids[chosen])
