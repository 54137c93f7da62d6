"""Semantic segmentation metrics from a confusion matrix: mIoU, F-mIoU, mAcc, pixel accuracy (protocol C)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from razer.arrays import IntArray
from razer.metrics.class_table import normalized_name
from razer.metrics.preset import Preset

NONE = ""
Confusion = Mapping[tuple[str, str], int]
"""Vertices by (true class, predicted class); "" stands for none."""


@dataclass(frozen=True, slots=True)
class ClassMetrics:
    """One class: intersection over union, recall of its vertices, and its true and predicted vertices."""

    iou: float
    accuracy: float
    n_truth: int
    n_predicted: int


@dataclass(frozen=True, slots=True)
class SemanticMetrics:
    """Means over the true classes that count, and the share of their vertices that is right; nan without any."""

    miou: float
    fmiou: float
    macc: float
    pixel_accuracy: float
    per_class: Mapping[str, ClassMetrics]


def confusion(truth: IntArray, predicted: IntArray, names: Mapping[int, str]) -> Counter[tuple[str, str]]:
    """Count the classes of V vertices: truth (V,) and predicted (V,), 0 for none, with the names of the others."""
    span = int(max(truth.max(initial=0), predicted.max(initial=0))) + 1
    pairs, counts = np.unique(truth.astype(np.int64) * span + predicted, return_counts=True)
    result: Counter[tuple[str, str]] = Counter()
    for pair, count in zip(pairs.tolist(), counts.tolist(), strict=True):
        result[names.get(pair // span, NONE), names.get(pair % span, NONE)] += count
    return result


def semantic_metrics(
    counts: Confusion, is_kept: Callable[[str], bool], count_ignored_points: bool = True
) -> SemanticMetrics:
    """HOV-SG's metrics. With n right, t true and p predicted vertices of a class: IoU = n / (t + p - n); mIoU =
    sum IoU / C and mAcc = sum (n / t) / C over the C kept classes that the truth has; F-mIoU = sum t IoU / sum t;
    pixel accuracy = sum n / sum t. p counts predictions on all vertices, or only on those of kept true classes."""
    truth: Counter[str] = Counter()
    predicted: Counter[str] = Counter()
    for (true_name, predicted_name), count in counts.items():
        is_evaluated = true_name != NONE and is_kept(true_name)
        truth[true_name] += count if is_evaluated else 0
        predicted[predicted_name] += count if is_evaluated or count_ignored_points else 0
    per_class = {
        name: _class_metrics(counts.get((name, name), 0), t, predicted[name]) for name, t in sorted(truth.items()) if t
    }
    return _means(per_class, sum(counts.get((name, name), 0) for name in per_class))


def kept_classes(preset: Preset, also_ignored: Iterable[str] | None = None) -> Callable[[str], bool]:
    """Whether a class counts by the preset's rules, or by another list of classes left out."""
    listed = {normalized_name(name) for name in preset.semantic_classes}
    ignored = {normalized_name(name) for name in (preset.semantic_ignored if also_ignored is None else also_ignored)}
    parts = preset.semantic_ignored_parts

    def is_kept(name: str) -> bool:
        key = normalized_name(name)
        return (not listed or key in listed) and key not in ignored and not any(part in key for part in parts)

    return is_kept


def _class_metrics(n: int, t: int, p: int) -> ClassMetrics:
    return ClassMetrics(n / (t + p - n), n / t, t, p)


def _means(per_class: Mapping[str, ClassMetrics], n_correct: int) -> SemanticMetrics:
    if not per_class:
        nan = float("nan")
        return SemanticMetrics(nan, nan, nan, nan, per_class)
    classes, total = per_class.values(), sum(c.n_truth for c in per_class.values())
    return SemanticMetrics(
        sum(c.iou for c in classes) / len(classes),
        sum(c.n_truth * c.iou for c in classes) / total,
        sum(c.accuracy for c in classes) / len(classes),
        n_correct / total,
        per_class,
    )
