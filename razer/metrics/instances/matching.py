"""Which prediction matches which truth: ScanNet's greedy rules on counts of shared vertices."""

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
    """Count what the labels of V vertices share: truth (V,) and predicted (V,) instance ids, <= 0 for nobody;
    vertices of void (V,) count as no evaluated truth. Raises ValueError for different lengths."""
    if truth.shape != predicted.shape or (void is not None and void.shape != truth.shape):
        raise ValueError(f"{truth.shape} true and {predicted.shape} predicted labels: one of each per vertex, please")
    evaluated = np.where((truth > 0) & (True if void is None else ~void), truth, 0)
    truth_ids, row = np.unique(np.append(evaluated, 0), return_inverse=True)
    predicted_ids, column = np.unique(np.append(predicted.clip(0), 0), return_inverse=True)
    # The appended pair of zeros makes sure that row 0 and column 0 stand for nobody.
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
    counted = [np.bincount(row[masks[i]], minlength=len(truth_ids)) for i in ids]
    table = np.array(counted, np.int64).reshape(len(ids), len(truth_ids)).T
    return Overlaps(
        truth_ids[1:].astype(np.int64),
        np.array(ids, np.int64),
        table[1:],
        np.bincount(row, minlength=len(truth_ids))[1:],
        table.sum(axis=0),
        table[0],
    )


@dataclass(frozen=True, slots=True)
class Judgement:
    """One scene, class and threshold: (score, right?) of everything that counts, truths that were missed, and the
    (truth id, predicted id) pairs that matched."""

    scores: Float64Array
    right: BoolArray
    missed: tuple[int, ...]
    pairs: tuple[tuple[int, int], ...]


def judge(
    overlaps: Overlaps, scores: Float64Array, threshold: float, min_region: int, strict: bool = True
) -> Judgement:
    """ScanNet's rules for one threshold on the intersection over union, which must be exceeded (or, where not strict,
    reached).

    Truths under min_region vertices are not looked for, predictions under it do not exist. Each truth takes the
    predictions (in order of id) above the threshold that no earlier truth took; a second one on the same truth is
    wrong with the lower of the two scores. A prediction above no threshold is wrong, unless the share of it on void
    or on too small truths exceeds the threshold: then it does not count. scores (P,)."""
    big_truth = overlaps.truth_sizes >= min_region
    real = overlaps.predicted_sizes >= min_region
    close = (overlaps.iou > threshold if strict else overlaps.iou >= threshold) & real
    outcomes, missed, pairs = _match_truths(overlaps, scores, close & big_truth[:, None], np.flatnonzero(big_truth))
    ignorable = overlaps.void + overlaps.counts[~big_truth].sum(axis=0)
    # Also closeness to a truth that is too small protects a prediction from being wrong.
    alone = real & ~close.any(axis=0)
    wrong = np.flatnonzero(alone & (ignorable / np.maximum(overlaps.predicted_sizes, 1) <= threshold))
    outcomes += [(float(scores[p]), False) for p in wrong]
    return Judgement(
        np.array([score for score, _ in outcomes], np.float64),
        np.array([right for _, right in outcomes], np.bool_),
        missed,
        pairs,
    )


def _match_truths(
    overlaps: Overlaps, scores: Float64Array, close: BoolArray, looked_for: IndexArray
) -> tuple[list[tuple[float, bool]], tuple[int, ...], tuple[tuple[int, int], ...]]:
    """Go through the truths: outcomes (score, right?), ids missed, pairs of ids."""
    taken = np.zeros(len(overlaps.predicted_ids), np.bool_)
    outcomes: list[tuple[float, bool]] = []
    missed, pairs = [], []
    for truth in looked_for:
        candidates = np.flatnonzero(close[truth] & ~taken)
        truth_id = int(overlaps.truth_ids[truth])
        if len(candidates) == 0:
            missed.append(truth_id)
            continue
        # The benchmark marks only the first candidate as taken, whichever of them scores best.
        taken[candidates[0]] = True
        ranked = candidates[np.argsort(-scores[candidates], kind="stable")]
        outcomes.append((float(scores[ranked[0]]), True))
        outcomes += [(float(scores[p]), False) for p in ranked[1:]]
        pairs.append((truth_id, int(overlaps.predicted_ids[ranked[0]])))
    return outcomes, tuple(missed), tuple(pairs)
