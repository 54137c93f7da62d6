"""Average precision of instances by the rules of the ScanNet benchmark."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from razer.metrics.matching import Ids, Judgement, Overlaps, count_overlaps, judge

AP_THRESHOLDS = tuple(round(0.5 + 0.05 * i, 2) for i in range(9))
ANY_CLASS = "any"


@dataclass(frozen=True, slots=True)
class ApSettings:
    """thresholds: intersections over union whose precisions are averaged (the benchmark stops at 0.90);
    min_region: vertices of the smallest truth looked for and of the smallest prediction that exists."""

    thresholds: tuple[float, ...] = AP_THRESHOLDS
    min_region: int = 100


@dataclass(frozen=True, slots=True)
class Scene:
    """One evaluated scene of V vertices: truth (V,) and predicted (V,) instance ids, <= 0 for nobody; scores of the
    predicted ids (1 where missing); classes of both kinds of ids, None for class-agnostic; void (V,) vertices
    that belong to no evaluated truth. Vertices nobody could see are left out beforehand."""

    truth: NDArray[np.integer]
    predicted: NDArray[np.integer]
    scores: Mapping[int, float] = field(default_factory=dict)
    truth_classes: Mapping[int, Any] | None = None
    predicted_classes: Mapping[int, Any] | None = None
    void: NDArray[np.bool_] | None = None


@dataclass(frozen=True, slots=True)
class ClassAp:
    """Average precision of one class: over the thresholds, at 0.5 and at 0.25; nan where there is no truth."""

    ap: float
    ap50: float
    ap25: float


@dataclass(frozen=True, slots=True)
class Match:
    """A true and a predicted instance whose intersection over union exceeds 0.5."""

    truth: int
    predicted: int
    iou: float


@dataclass(frozen=True, slots=True)
class InstanceAp:
    """The means over the classes that have a truth, the classes, and, of one scene at 0.5 and regardless of class,
    what matched, which predictions double a truth that another one matched, and which truths were missed."""

    ap: float
    ap50: float
    ap25: float
    per_class: Mapping[Any, ClassAp]
    matches: tuple[Match, ...] = ()
    duplicates: tuple[int, ...] = ()
    missed: tuple[int, ...] = ()


def instance_ap(scene: Scene, settings: ApSettings | None = None) -> InstanceAp:
    """Evaluate one scene, with the details of what matched what."""
    settings = settings or ApSettings()
    overlaps = _counted(scene)
    result = _mean_over_classes([(scene, overlaps)], settings)
    judgement = judge(overlaps, _scores(scene, overlaps), 0.5, settings.min_region)
    matches = _matches(overlaps, judgement)
    doubles = _duplicates(overlaps, matches, settings.min_region)
    return InstanceAp(result.ap, result.ap50, result.ap25, result.per_class, matches, doubles, judgement.missed)


def pooled_instance_ap(scenes: Sequence[Scene], settings: ApSettings | None = None) -> InstanceAp:
    """Evaluate several scenes as the benchmark does: all their predictions in one ranking for each class."""
    return _mean_over_classes([(scene, _counted(scene)) for scene in scenes], settings or ApSettings())


def average_precision(scores: NDArray[np.float64], right: NDArray[np.bool_], missed: int) -> float:
    """Area under precision over recall as the benchmark sums it: at each distinct score the predictions that score
    as much or more count; then a last point of precision 1 and recall 0; each precision is weighted by half the
    distance of its neighbours' recalls. scores and right (N,) hold every prediction that counts."""
    if len(scores) == 0:
        return 0.0
    order = np.argsort(scores, kind="stable")
    first = np.unique(scores[order], return_index=True)[1]
    right_above = right.sum() - np.concatenate([[0], np.cumsum(right[order])])[first]
    precision = np.append(right_above / (len(scores) - first), 1.0)
    # Recalls times the number of truths, which keeps a perfect result exactly 1.
    found = np.append(right_above, 0.0)
    steps = np.convolve(np.concatenate([found[:1], found, [0.0]]), [-0.5, 0, 0.5], "valid")
    return float(precision @ steps) / max(int(right.sum()) + missed, 1)


def _counted(scene: Scene) -> Overlaps:
    void = np.zeros(len(scene.truth), np.bool_) if scene.void is None else scene.void
    if scene.truth_classes is not None:
        # Truths of no evaluated class are void, as the benchmark's unlisted classes are.
        void = void | ~np.isin(scene.truth, list(scene.truth_classes))
    return count_overlaps(np.asarray(scene.truth, np.int64), np.asarray(scene.predicted, np.int64), void)


def _scores(scene: Scene, overlaps: Overlaps) -> NDArray[np.float64]:
    return np.array([scene.scores.get(int(p), 1.0) for p in overlaps.predicted_ids], np.float64)


def _class_of(ids: Ids, classes: Mapping[int, Any] | None) -> list[Any]:
    return [ANY_CLASS if classes is None else classes.get(int(i)) for i in ids]


def _mean_over_classes(scenes: Sequence[tuple[Scene, Overlaps]], settings: ApSettings) -> InstanceAp:
    names = {name for scene, overlaps in scenes for name in _class_of(overlaps.truth_ids, scene.truth_classes)}
    names |= {name for scene, _ in scenes for name in (scene.truth_classes or {}).values()}
    per_class = {name: _class_ap(scenes, name, settings) for name in sorted(names, key=str)}
    found = per_class.values()
    ap, ap50, ap25 = (_nanmean([getattr(c, key) for c in found]) for key in ("ap", "ap50", "ap25"))
    return InstanceAp(ap, ap50, ap25, per_class)


def _nanmean(values: list[float]) -> float:
    known = [value for value in values if not np.isnan(value)]
    return float(np.mean(known)) if known else float("nan")


def _class_ap(scenes: Sequence[tuple[Scene, Overlaps]], name: Any, settings: ApSettings) -> ClassAp:
    chosen = [_of_class(scene, overlaps, name) for scene, overlaps in scenes]

    def at(threshold: float) -> float:
        return _ap_at(chosen, threshold, settings.min_region)

    return ClassAp(float(np.mean([at(t) for t in settings.thresholds])), at(0.5), at(0.25))


def _of_class(scene: Scene, overlaps: Overlaps, name: Any) -> tuple[Overlaps, NDArray[np.float64]]:
    """The truths and predictions of one class, with the predictions' scores."""
    truth = np.array([c == name for c in _class_of(overlaps.truth_ids, scene.truth_classes)], np.bool_)
    agnostic = scene.truth_classes is None
    classes = _class_of(overlaps.predicted_ids, None if agnostic else scene.predicted_classes or {})
    predicted = np.array([c == name for c in classes], np.bool_)
    return overlaps.select(truth, predicted), _scores(scene, overlaps)[predicted]


def _ap_at(chosen: Sequence[tuple[Overlaps, NDArray[np.float64]]], threshold: float, min_region: int) -> float:
    """AP of one class at one threshold over all scenes: nan without truth, 0 without predictions."""
    if not any((overlaps.truth_sizes >= min_region).any() for overlaps, _ in chosen):
        return float("nan")
    judged = [judge(overlaps, scores, threshold, min_region) for overlaps, scores in chosen]
    return average_precision(
        np.concatenate([j.scores for j in judged]),
        np.concatenate([j.right for j in judged]),
        sum(len(j.missed) for j in judged),
    )


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
