"""Instance average precision (AP, AP50, AP25) by the rules of the ScanNet benchmark."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from razer.arrays import BoolArray, Float64Array, Int64Array, IntArray
from razer.metrics.instances.match_summary import Match, summarize_matches
from razer.metrics.instances.matching import (
    MatchOutcomes,
    Overlaps,
    count_mask_overlaps,
    count_overlaps,
    match_predictions,
)
from razer.metrics.instances.precision_recall import average_precision

AP_THRESHOLDS = tuple(round(0.5 + 0.05 * i, 2) for i in range(9))
ANY_CLASS = "any"


@dataclass(frozen=True, slots=True)
class ApSettings:
    """thresholds: intersections over union whose precisions are averaged (the benchmark stops at 0.90);
    min_region: vertices of the smallest truth and of the smallest prediction that are evaluated;
    strict: whether thresholds must be exceeded or reached; optimistic: whether matched predictions get the score 1."""

    thresholds: tuple[float, ...] = AP_THRESHOLDS
    min_region: int = 100
    strict: bool = True
    optimistic: bool = False


@dataclass(frozen=True, slots=True)
class Scene:
    """One evaluated scene of V vertices: truth (V,) instance ids and predicted ones, either ids (V,) or, where they may
    overlap, id -> vertex numbers; ids <= 0 are unlabelled. scores of the predicted ids (1 where missing); classes of
    both kinds of ids, None for class-agnostic; void (V,) vertices that belong to no evaluated truth. Vertices that no
    frame observed are left out beforehand."""

    truth: IntArray
    predicted: IntArray | Mapping[int, IntArray]
    scores: Mapping[int, float] = field(default_factory=dict)
    truth_classes: Mapping[int, Any] | None = None
    predicted_classes: Mapping[int, Any] | None = None
    void: BoolArray | None = None

    def overlaps(self) -> Overlaps:
        """The vertices that true and predicted instances share."""
        void = np.zeros(len(self.truth), np.bool_) if self.void is None else self.void
        if self.truth_classes is not None:
            # Truths of no evaluated class are void, as the benchmark's unlisted classes are.
            void = void | ~np.isin(self.truth, list(self.truth_classes))
        truth = np.asarray(self.truth, np.int64)
        if isinstance(self.predicted, Mapping):
            return count_mask_overlaps(truth, self.predicted, void)
        return count_overlaps(truth, np.asarray(self.predicted, np.int64), void)


@dataclass(frozen=True, slots=True)
class ClassAp:
    """Average precision of one class: over the thresholds, at 0.5 and at 0.25; nan where there is no truth."""

    ap: float
    ap50: float
    ap25: float


@dataclass(frozen=True, slots=True)
class InstanceAp:
    """The means over the classes that have a truth, the classes, and, of one scene at 0.5 and regardless of class,
    the matches, the predictions that duplicate a matched truth, and the truths that were missed."""

    ap: float
    ap50: float
    ap25: float
    per_class: Mapping[Any, ClassAp]
    matches: tuple[Match, ...] = ()
    duplicates: tuple[int, ...] = ()
    missed: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class ClassOutcomes:
    """One class of one scene: whether it has a truth to evaluate, and the outcomes at each threshold."""

    has_truth: bool
    at: Mapping[float, MatchOutcomes]


SceneOutcomes = Mapping[Any, ClassOutcomes]
"""Outcomes of a scene by class: enough for its own AP and for one pooled with other scenes."""


def instance_ap(scene: Scene, settings: ApSettings | None = None) -> InstanceAp:
    """Evaluate one scene, with the list of matches."""
    settings = settings or ApSettings()
    overlaps = scene.overlaps()
    result = pooled_ap([match_scene(scene, overlaps, settings)], settings)
    summary = summarize_matches(overlaps, scores_of(scene, overlaps), settings.min_region, settings.strict)
    return InstanceAp(result.ap, result.ap50, result.ap25, result.per_class, *summary)


def pooled_instance_ap(scenes: Iterable[Scene], settings: ApSettings | None = None) -> InstanceAp:
    """Evaluate several scenes as the benchmark does: all their predictions in one ranking for each class."""
    settings = settings or ApSettings()
    return pooled_ap([match_scene(scene, scene.overlaps(), settings) for scene in scenes], settings)


def match_scene(scene: Scene, overlaps: Overlaps, settings: ApSettings) -> SceneOutcomes:
    """Match predictions to truths for every class that has either in the scene."""
    is_agnostic = scene.truth_classes is None
    truth = _class_of(overlaps.truth_ids, scene.truth_classes)
    predicted = _class_of(overlaps.predicted_ids, None if is_agnostic else scene.predicted_classes or {})
    names = set(truth) | set(predicted) | set((scene.truth_classes or {}).values())
    scores = scores_of(scene, overlaps)
    outcomes = {}
    for name in sorted(names - {None}, key=str):
        rows, columns = (np.array([c == name for c in classes], np.bool_) for classes in (truth, predicted))
        outcomes[name] = _match_class(overlaps.select(rows, columns), scores[columns], settings)
    return outcomes


def pooled_ap(scenes: Sequence[SceneOutcomes], settings: ApSettings) -> InstanceAp:
    """Average precision over scenes, all predictions of a class in one ranking."""
    names = {name for scene in scenes for name in scene}
    per_class = {}
    for name in sorted(names, key=str):
        parts = [scene[name] for scene in scenes if name in scene]
        at = {t: _ap_at(parts, t) for t in (*settings.thresholds, 0.5, 0.25)}
        per_class[name] = ClassAp(float(np.mean([at[t] for t in settings.thresholds])), at[0.5], at[0.25])
    ap, ap50, ap25 = (nanmean(getattr(c, key) for c in per_class.values()) for key in ("ap", "ap50", "ap25"))
    return InstanceAp(ap, ap50, ap25, per_class)


def nanmean(values: Iterable[float]) -> float:
    """The mean of those that are a number, nan if none is."""
    numbers = [value for value in values if not np.isnan(value)]
    return float(np.mean(numbers)) if numbers else float("nan")


def scores_of(scene: Scene, overlaps: Overlaps) -> Float64Array:
    """The scores (P,) of the predictions, 1 where they have none."""
    return np.array([scene.scores.get(int(p), 1.0) for p in overlaps.predicted_ids], np.float64)


def _class_of(ids: Int64Array, classes: Mapping[int, Any] | None) -> list[Any]:
    return [ANY_CLASS if classes is None else classes.get(int(i)) for i in ids]


def _match_class(overlaps: Overlaps, scores: Float64Array, settings: ApSettings) -> ClassOutcomes:
    at = {}
    for threshold in {*settings.thresholds, 0.5, 0.25}:
        outcome = match_predictions(overlaps, scores, threshold, settings.min_region, settings.strict)
        ranked = np.where(outcome.is_true_positive, 1.0, outcome.scores) if settings.optimistic else outcome.scores
        at[threshold] = MatchOutcomes(ranked, outcome.is_true_positive, outcome.missed, outcome.pairs)
    return ClassOutcomes(bool((overlaps.truth_sizes >= settings.min_region).any()), at)


def _ap_at(parts: Sequence[ClassOutcomes], threshold: float) -> float:
    """AP of one class at one threshold over all scenes: nan without truth, 0 without predictions."""
    if not any(part.has_truth for part in parts):
        return float("nan")
    return average_precision(*pooled_outcomes(parts, threshold))


def pooled_outcomes(parts: Sequence[ClassOutcomes], threshold: float) -> tuple[Float64Array, BoolArray, int]:
    """Scores (N,), whether each is a true positive (N,) and the number of missed truths of a class over scenes."""
    outcomes = [part.at[threshold] for part in parts]
    scores = np.concatenate([o.scores for o in outcomes])
    return scores, np.concatenate([o.is_true_positive for o in outcomes]), sum(len(o.missed) for o in outcomes)
