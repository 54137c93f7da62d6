"""Greedy matching of predicted to true instances by the ScanNet benchmark's rules, on counts of shared vertices."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from razer.arrays import BoolArray, Float64Array, IndexArray, Int64Array, IntArray


@dataclass(frozen=True, slots=True)
class Overlaps:
    """Shared vertices of G true and P predicted instances: truth_ids (G,) and predicted_ids (P,) increasing, counts
    (G, P), truth_sizes (G,), predicted_sizes (P,) and void (P,), the predicted vertices on no evaluated truth."""

    truth_ids: Int64Array
    predicted_ids: Int64Array
    counts: Int64Array
    truth_sizes: Int64Array
    predicted_sizes: Int64Array
    void: Int64Array

    def select(self, truth: BoolArray, predicted: BoolArray) -> Overlaps:
        """Only the given truths (G,) and predictions (P,), with sizes and void as they were."""
        return Overlaps(
            self.truth_ids[truth],
            self.predicted_ids[predicted],
            self.counts[np.ix_(truth, predicted)],
            self.truth_sizes[truth],
            self.predicted_sizes[predicted],
            self.void[predicted],
        )

    @property
    def iou(self) -> Float64Array:
        """Intersection over union (G, P)."""
        union = self.truth_sizes[:, None] + self.predicted_sizes - self.counts
        return self.counts / np.maximum(union, 1)


def count_overlaps(truth: Int64Array, predicted: Int64Array, void: BoolArray | None = None) -> Overlaps:
    """Count the vertices that instances share: truth (V,) and predicted (V,) instance ids, <= 0 for none;
    vertices of void (V,) count as no evaluated truth. Raises ValueError for different lengths."""
    if truth.shape != predicted.shape or (void is not None and void.shape != truth.shape):
        raise ValueError(f"{truth.shape} true and {predicted.shape} predicted labels: one of each per vertex is needed")
    evaluated = np.where((truth > 0) & (True if void is None else ~void), truth, 0)
    truth_ids, row = np.unique(np.append(evaluated, 0), return_inverse=True)
    predicted_ids, column = np.unique(np.append(predicted.clip(0), 0), return_inverse=True)
    # The appended pair of zeros makes sure that row 0 and column 0 stand for no instance.
    flat = np.bincount(row * len(predicted_ids) + column, minlength=len(truth_ids) * len(predicted_ids))
    table = flat.reshape(len(truth_ids), len(predicted_ids))
    return Overlaps(
        truth_ids[1:].astype(np.int64),
        predicted_ids[1:].astype(np.int64),
        table[1:, 1:],
        table[1:].sum(axis=1),
        table[:, 1:].sum(axis=0),
        table[0, 1:],
    )


def count_mask_overlaps(truth: Int64Array, masks: Mapping[int, IntArray], void: BoolArray) -> Overlaps:
    """As count_overlaps, for predictions that may overlap: masks, id -> numbers (M,) of their vertices, each once."""
    truth_ids, row = np.unique(np.append(np.where((truth > 0) & ~void, truth, 0), 0), return_inverse=True)
    ids = sorted(masks)
    counts = [np.bincount(row[masks[i]], minlength=len(truth_ids)) for i in ids]
    table = np.array(counts, np.int64).reshape(len(ids), len(truth_ids)).T
    return Overlaps(
        truth_ids[1:].astype(np.int64),
        np.array(ids, np.int64),
        table[1:],
        np.bincount(row, minlength=len(truth_ids))[1:],
        table.sum(axis=0),
        table[0],
    )


@dataclass(frozen=True, slots=True)
class MatchOutcomes:
    """One scene, class and threshold: score and whether a true positive (N,) of everything that counts, truths that
    were missed (false negatives), and the (truth id, predicted id) pairs that matched."""

    scores: Float64Array
    is_true_positive: BoolArray
    missed: tuple[int, ...]
    pairs: tuple[tuple[int, int], ...]


def match_predictions(
    overlaps: Overlaps, scores: Float64Array, threshold: float, min_region: int, strict: bool = True
) -> MatchOutcomes:
    """ScanNet's rules for one threshold on the intersection over union.

    Each truth takes the predictions (in order of id) above the threshold that no earlier truth took; a second one on
    the same truth is a false positive with the lower of the two scores. A prediction that overlaps no truth enough is a
    false positive, unless the share of it on void or on too small truths exceeds the threshold: then it does not count.

    Args:
        overlaps: shared vertices of G truths and P predictions.
        scores: (P,), confidences of the predictions.
        threshold: intersection over union of a match.
        min_region: vertices of the smallest truth and prediction that are evaluated.
        strict: whether the threshold must be exceeded, or reached.
    """
    is_large_truth = overlaps.truth_sizes >= min_region
    is_large_prediction = overlaps.predicted_sizes >= min_region
    is_close = (overlaps.iou > threshold if strict else overlaps.iou >= threshold) & is_large_prediction
    outcomes, missed, pairs = _match_truths(
        overlaps, scores, is_close & is_large_truth[:, None], np.flatnonzero(is_large_truth)
    )
    ignorable = overlaps.void + overlaps.counts[~is_large_truth].sum(axis=0)
    # Overlap with a truth that is too small also protects a prediction from being a false positive.
    is_unmatched = is_large_prediction & ~is_close.any(axis=0)
    false_positives = np.flatnonzero(is_unmatched & (ignorable / np.maximum(overlaps.predicted_sizes, 1) <= threshold))
    outcomes += [(float(scores[p]), False) for p in false_positives]
    return MatchOutcomes(
        np.array([score for score, _ in outcomes], np.float64),
        np.array([is_true_positive for _, is_true_positive in outcomes], np.bool_),
        missed,
        pairs,
    )


def _match_truths(
    overlaps: Overlaps, scores: Float64Array, is_close: BoolArray, truths: IndexArray
) -> tuple[list[tuple[float, bool]], tuple[int, ...], tuple[tuple[int, int], ...]]:
    """Match each truth in turn: outcomes (score, whether a true positive), ids missed, pairs of ids."""
    is_taken = np.zeros(len(overlaps.predicted_ids), np.bool_)
    outcomes: list[tuple[float, bool]] = []
    missed, pairs = [], []
    for truth in truths:
        candidates = np.flatnonzero(is_close[truth] & ~is_taken)
        truth_id = int(overlaps.truth_ids[truth])
        if len(candidates) == 0:
            missed.append(truth_id)
            continue
        # The benchmark marks only the first candidate as taken, whichever of them scores best.
        is_taken[candidates[0]] = True
        ranked = candidates[np.argsort(-scores[candidates], kind="stable")]
        outcomes.append((float(scores[ranked[0]]), True))
        outcomes += [(float(scores[p]), False) for p in ranked[1:]]
        pairs.append((truth_id, int(overlaps.predicted_ids[ranked[0]])))
    return outcomes, tuple(missed), tuple(pairs)
