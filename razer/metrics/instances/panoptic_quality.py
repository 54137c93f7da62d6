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
    """Of one class: sum of the matches' intersections over union, matches, wrong predictions, missed truths."""

    iou_sum: float = 0.0
    matches: int = 0
    wrong: int = 0
    missed: int = 0

    def __add__(self, other: PanopticCounts) -> PanopticCounts:
        return PanopticCounts(
            self.iou_sum + other.iou_sum,
            self.matches + other.matches,
            self.wrong + other.wrong,
            self.missed + other.missed,
        )

    @property
    def numbers(self) -> tuple[float, float, float]:
        """PQ = sum IoU / (TP + FP/2 + FN/2), SQ = sum IoU / TP (0 without matches), RQ = TP / (TP + FP/2 + FN/2)."""
        weight = self.matches + (self.wrong + self.missed) / 2
        if weight == 0:
            return (float("nan"),) * 3
        segmentation = self.iou_sum / self.matches if self.matches else 0.0
        return self.iou_sum / weight, segmentation, self.matches / weight


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
    """Match the segments (V,) of truth and prediction, 0 for none, class by class; without classes all are of one.

    A pair matches where IoU > 0.5, with the union lacking what the prediction has on vertices of no true segment.
    Predictions with more than half of their vertices there, or on too small truths, are neither right nor wrong."""
    void = truth <= 0
    if truth_classes is not None:
        void = void | ~np.isin(truth, list(truth_classes))
    if truth_classes is not None and predicted_classes is not None:
        predicted = np.where(np.isin(predicted, list(predicted_classes)), predicted, 0)
    overlaps = count_overlaps(np.asarray(truth, np.int64), np.asarray(predicted, np.int64), void)
    true_names, predicted_names = (
        np.array([_index_of(classes, int(i)) for i in ids], dtype=object)
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
    per_class = {name: total[name].numbers for name in sorted(total, key=str)}
    known = [numbers for numbers in per_class.values() if not np.isnan(numbers[0])]
    pq, sq, rq = np.mean(known, axis=0) if known else [float("nan")] * 3
    return PanopticQuality(float(pq), float(sq), float(rq), per_class)


def merge_stuff(
    instances: IntArray,
    classes: IntArray,
    instance_classes: Mapping[int, int],
    stuff: Iterable[int],
) -> tuple[Int64Array, dict[int, int]]:
    """Segments (V,) and their classes out of instances (V,) and classes (V,), 0 for none: each instance is one, and
    each stuff class, whose vertices and instances are merged, is one with the id after the highest instance + class."""
    stuff = sorted(set(stuff))
    of_vertex = np.where(instances > 0, _looked_up(instances, instance_classes), classes)
    first = int(instances.max(initial=0)) + 1
    merged = np.isin(of_vertex, stuff)
    segments = np.where(merged, first + of_vertex, np.maximum(instances, 0))
    things = {i: c for i, c in instance_classes.items() if c not in stuff}
    return segments, things | {first + c: c for c in stuff}


def _looked_up(ids: IntArray, classes: Mapping[int, int]) -> Int64Array:
    known, place = np.unique(ids, return_inverse=True)
    return np.array([classes.get(int(i), 0) for i in known], np.int64)[place].reshape(ids.shape)


def _index_of(classes: Mapping[int, Hashable] | None, number: int) -> Hashable:
    return ANY_CLASS if classes is None else classes.get(number)


def _counts(overlaps: Overlaps, truth: BoolArray, predicted: BoolArray, min_region: int) -> PanopticCounts:
    chosen = overlaps.select(truth.astype(np.bool_), predicted.astype(np.bool_))
    big, real = chosen.truth_sizes >= min_region, chosen.predicted_sizes >= min_region
    union = chosen.truth_sizes[:, None] + chosen.predicted_sizes - chosen.counts - chosen.void
    iou = chosen.counts / np.maximum(union, 1)
    matched = (iou > 0.5) & big[:, None] & real
    ignorable = chosen.void + chosen.counts[~big].sum(axis=0)
    wrong = real & ~matched.any(axis=0) & (2 * ignorable <= chosen.predicted_sizes)
    missed = big & ~matched.any(axis=1)
    # More than half of both lies in the overlap, so that no segment can match twice.
    return PanopticCounts(float(iou[matched].sum()), int(matched.sum()), int(wrong.sum()), int(missed.sum()))
