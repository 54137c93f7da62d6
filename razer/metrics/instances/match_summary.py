"""Class-agnostic matches at IoU 0.5: true positives, duplicates, missed truths."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from razer.arrays import Float64Array
from razer.metrics.instances.matching import MatchOutcomes, Overlaps, match_predictions


class Match(NamedTuple):
    """A true and a predicted instance whose intersection over union exceeds 0.5."""

    truth: int
    predicted: int
    iou: float


class MatchSummary(NamedTuple):
    """The matches, the ids of predictions that duplicate a truth that another one matched, the ids of missed truths."""

    matches: tuple[Match, ...]
    duplicates: tuple[int, ...]
    missed: tuple[int, ...]


def summarize_matches(overlaps: Overlaps, scores: Float64Array, min_region: int, strict: bool = True) -> MatchSummary:
    """Match G truths and P predictions by ScanNet's rules at IoU 0.5.

    Args:
        overlaps: shared vertices, (G, P).
        scores: (P,), confidences of the predictions.
        min_region: vertices of the smallest truth and prediction that are evaluated.
        strict: whether 0.5 must be exceeded, or reached.
    """
    outcomes = match_predictions(overlaps, scores, 0.5, min_region, strict)
    matches = _matches(overlaps, outcomes)
    return MatchSummary(matches, _duplicates(overlaps, matches, min_region), outcomes.missed)


def _matches(overlaps: Overlaps, outcomes: MatchOutcomes) -> tuple[Match, ...]:
    iou = overlaps.iou
    rows = np.searchsorted(overlaps.truth_ids, [t for t, _ in outcomes.pairs])
    columns = np.searchsorted(overlaps.predicted_ids, [p for _, p in outcomes.pairs])
    return tuple(Match(t, p, float(iou[r, c])) for (t, p), r, c in zip(outcomes.pairs, rows, columns, strict=True))


def _duplicates(overlaps: Overlaps, matches: tuple[Match, ...], min_region: int) -> tuple[int, ...]:
    """Predictions that match nothing at 0.5 though most of their vertices lie in a truth that another one matched."""
    matched_truth = np.isin(overlaps.truth_ids, [m.truth for m in matches])
    unmatched = ~np.isin(overlaps.predicted_ids, [m.predicted for m in matches])
    inside = (2 * overlaps.counts[matched_truth] > overlaps.predicted_sizes).any(axis=0)
    chosen = unmatched & inside & (overlaps.predicted_sizes >= min_region)
    return tuple(int(p) for p in overlaps.predicted_ids[chosen])
