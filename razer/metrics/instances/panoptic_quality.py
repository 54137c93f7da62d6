"""Panoptic quality (Kirillov et al., CVPR 2019): PQ = SQ x RQ, of segments that do not overlap."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from razer.arrays import BoolArray, Int64Array, IntArray
from razer.metrics.instances.matching import Overlaps, count_overlaps

ANY_CLASS = "any"


@dataclass(frozen=True, slots=True)
class PanopticCounts:
    """Of one class: sum of the matches' IoUs, and the numbers of true and false positives and false negatives."""

    iou_sum: float = 0.0
    true_positives: int = 0
    false_positives: int = 0
    false_negatives: int = 0

    def __add__(self, other: PanopticCounts) -> PanopticCounts:
        return PanopticCounts(
            self.iou_sum + other.iou_sum,
            self.true_positives + other.true_positives,
            self.false_positives + other.false_positives,
            self.false_negatives + other.false_negatives,
        )

    @property
    def quality(self) -> tuple[float, float, float]:
        """PQ = sum IoU / (TP + FP/2 + FN/2), SQ = sum IoU / TP (0 without TP), RQ = TP / (TP + FP/2 + FN/2)."""
        weight = self.true_positives + (self.false_positives + self.false_negatives) / 2
        if weight == 0:
            return (float("nan"),) * 3
        segmentation = self.iou_sum / self.true_positives if self.true_positives else 0.0
        return self.iou_sum / weight, segmentation, self.true_positives / weight


@dataclass(frozen=True, slots=True)
class PanopticQuality:
    """Means over the classes that have a segment that counts; nan without any."""

    pq: float
    sq: float
    rq: float
    per_class: Mapping[Any, tuple[float, float, float]]


def count_segments(
    truth: IntArray,
    predicted: IntArray,
    truth_classes: Mapping[int, Hashable] | None = None,
    predicted_classes: Mapping[int, Hashable] | None = None,
    min_region: int = 1,
) -> dict[Any, PanopticCounts]:
    """Match the segments of truth and prediction class by class.

    A pair matches where IoU > 0.5, with the union lacking what the prediction has on vertices of no true segment.
    Predictions with more than half of their vertices there, or on too small truths, do not count.

    Args:
        truth: (V,), segment ids, 0 for none.
        predicted: (V,), segment ids, 0 for none.
        truth_classes: class by segment id; None: all are of one class.
        predicted_classes: the same for the prediction.
        min_region: vertices of the smallest segment that is evaluated.
    """
    void = truth <= 0
    if truth_classes is not None:
        void = void | ~np.isin(truth, list(truth_classes))
    if truth_classes is not None and predicted_classes is not None:
        predicted = np.where(np.isin(predicted, list(predicted_classes)), predicted, 0)
    overlaps = count_overlaps(np.asarray(truth, np.int64), np.asarray(predicted, np.int64), void)
    true_names, predicted_names = (
        np.array([_class_of(classes, int(i)) for i in ids], dtype=object)
        for ids, classes in (
            (overlaps.truth_ids, truth_classes),
            (overlaps.predicted_ids, None if truth_classes is None else predicted_classes),
        )
    )
    names = {name for name in (*true_names, *predicted_names) if name is not None}
    return {name: _counts(overlaps, true_names == name, predicted_names == name, min_region) for name in names}


def panoptic_quality(counts: Iterable[Mapping[Any, PanopticCounts]]) -> PanopticQuality:
    """The quality over scenes, whose counts are added up class by class."""
    total: dict[Any, PanopticCounts] = {}
    for scene in counts:
        for name, part in scene.items():
            total[name] = total.get(name, PanopticCounts()) + part
    per_class = {name: total[name].quality for name in sorted(total, key=str)}
    evaluated = [quality for quality in per_class.values() if not np.isnan(quality[0])]
    pq, sq, rq = np.mean(evaluated, axis=0) if evaluated else [float("nan")] * 3
    return PanopticQuality(float(pq), float(sq), float(rq), per_class)


def merge_stuff(
    instances: IntArray, classes: IntArray, instance_classes: Mapping[int, int], stuff: Iterable[int]
) -> tuple[Int64Array, dict[int, int]]:
    """Panoptic segments (V,) and their classes: each instance is a segment, and so is each stuff class, whose vertices
    and instances are merged, with the id after the highest instance + class.

    Args:
        instances: (V,), instance ids, 0 for none.
        classes: (V,), class numbers, 0 for none.
        instance_classes: class number by instance id.
        stuff: numbers of the stuff classes.
    """
    stuff = sorted(set(stuff))
    vertex_classes = np.where(instances > 0, _lookup(instances, instance_classes), classes)
    first = int(instances.max(initial=0)) + 1
    is_stuff = np.isin(vertex_classes, stuff)
    segments = np.where(is_stuff, first + vertex_classes, np.maximum(instances, 0))
    things = {i: c for i, c in instance_classes.items() if c not in stuff}
    return segments, things | {first + c: c for c in stuff}


def _lookup(ids: IntArray, classes: Mapping[int, int]) -> Int64Array:
    distinct, index = np.unique(ids, return_inverse=True)
    return np.array([classes.get(int(i), 0) for i in distinct], np.int64)[index].reshape(ids.shape)


def _class_of(classes: Mapping[int, Hashable] | None, number: int) -> Hashable:
    return ANY_CLASS if classes is None else classes.get(number)


def _counts(overlaps: Overlaps, truth: BoolArray, predicted: BoolArray, min_region: int) -> PanopticCounts:
    chosen = overlaps.select(truth.astype(np.bool_), predicted.astype(np.bool_))
    is_large_truth, is_large_prediction = chosen.truth_sizes >= min_region, chosen.predicted_sizes >= min_region
    union = chosen.truth_sizes[:, None] + chosen.predicted_sizes - chosen.counts - chosen.void
    iou = chosen.counts / np.maximum(union, 1)
    matched = (iou > 0.5) & is_large_truth[:, None] & is_large_prediction
    ignorable = chosen.void + chosen.counts[~is_large_truth].sum(axis=0)
    false_positives = is_large_prediction & ~matched.any(axis=0) & (2 * ignorable <= chosen.predicted_sizes)
    false_negatives = is_large_truth & ~matched.any(axis=1)
    # More than half of both lies in the overlap, so that no segment can match twice.
    return PanopticCounts(
        float(iou[matched].sum()), int(matched.sum()), int(false_positives.sum()), int(false_negatives.sum())
    )
