"""Semantic segmentation: one confusion of true and predicted classes, and the numbers read off it (protocol C)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from razer.arrays import IntArray
from razer.metrics.class_table import plain
from razer.metrics.preset import Preset

NONE = ""
Confusion = Mapping[tuple[str, str], int]
"""Vertices by (true class, predicted class); "" stands for none."""


@dataclass(frozen=True, slots=True)
class ClassNumbers:
    """One class: intersection over union, share of its vertices found, and its true and predicted vertices."""

    iou: float
    accuracy: float
    n_truth: int
    n_predicted: int


@dataclass(frozen=True, slots=True)
class SemanticNumbers:
    """Means over the true classes that count, and the share of their vertices that is right; nan without any."""

    miou: float
    fmiou: float
    macc: float
    pixel_accuracy: float
    per_class: Mapping[str, ClassNumbers]


def confusion(truth: IntArray, predicted: IntArray, names: Mapping[int, str]) -> Counter[tuple[str, str]]:
    """Count the classes of V vertices: truth (V,) and predicted (V,), 0 for none, with the names of the others."""
    span = int(max(truth.max(initial=0), predicted.max(initial=0))) + 1
    pairs, counts = np.unique(truth.astype(np.int64) * span + predicted, return_counts=True)
    result: Counter[tuple[str, str]] = Counter()
    for pair, count in zip(pairs.tolist(), counts.tolist(), strict=True):
        result[names.get(pair // span, NONE), names.get(pair % span, NONE)] += count
    return result


def semantic_numbers(
    counted: Confusion, kept: Callable[[str], bool], count_ignored_points: bool = True
) -> SemanticNumbers:
    """With n right, t true and p predicted vertices of a class: IoU = n / (t + p - n); mIoU = sum IoU / C and
    mAcc = sum (n / t) / C over the C kept classes that the truth has; F-mIoU = sum t IoU / sum t; pixel accuracy =
    sum n / sum t. p counts predictions on all vertices, or only on those of kept true classes.
    Source: HOV-SG's metrics, where classes left out do not count in C and sum t."""
    truth: Counter[str] = Counter()
    predicted: Counter[str] = Counter()
    for (true_name, predicted_name), count in counted.items():
        counts = true_name != NONE and kept(true_name)
        truth[true_name] += count if counts else 0
        predicted[predicted_name] += count if counts or count_ignored_points else 0
    per_class = {
        name: _class_numbers(counted.get((name, name), 0), t, predicted[name]) for name, t in sorted(truth.items()) if t
    }
    return _means(per_class, sum(counted.get((name, name), 0) for name in per_class))


def kept_classes(preset: Preset, also_ignored: Iterable[str] | None = None) -> Callable[[str], bool]:
    """Whether a class counts by the preset's rules, or by another list of classes left out."""
    looked_at = {plain(name) for name in preset.semantic_classes}
    ignored = {plain(name) for name in (preset.semantic_ignored if also_ignored is None else also_ignored)}
    parts = preset.semantic_ignored_parts

    def kept(name: str) -> bool:
        simple = plain(name)
        return (not looked_at or simple in looked_at) and simple not in ignored and not any(p in simple for p in parts)

    return kept


def _class_numbers(n: int, t: int, p: int) -> ClassNumbers:
    return ClassNumbers(n / (t + p - n), n / t, t, p)


def _means(per_class: Mapping[str, ClassNumbers], right: int) -> SemanticNumbers:
    if not per_class:
        nan = float("nan")
        return SemanticNumbers(nan, nan, nan, nan, per_class)
    classes, total = per_class.values(), sum(c.n_truth for c in per_class.values())
    return SemanticNumbers(
        sum(c.iou for c in classes) / len(classes),
        sum(c.n_truth * c.iou for c in classes) / total,
        sum(c.accuracy for c in classes) / len(classes),
        right / total,
        per_class,
    )
