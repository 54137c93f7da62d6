"""Average precision of instances by the rules of the ScanNet benchmark."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from razer.arrays import BoolArray, Float64Array, Int64Array, IntArray
from razer.metrics.instances.match_summary import Match, find_matches
from razer.metrics.instances.matching import Judgement, Overlaps, count_mask_overlaps, count_overlaps, judge
from razer.metrics.instances.precision_recall import average_precision

AP_THRESHOLDS = tuple(round(0.5 + 0.05 * i, 2) for i in range(9))
ANY_CLASS = "any"


@dataclass(frozen=True, slots=True)
class ApSettings:
    """thresholds: intersections over union whose precisions are averaged (the benchmark stops at 0.90);
    min_region: vertices of the smallest truth looked for and of the smallest prediction that exists;
    strict: whether thresholds must be exceeded or reached; optimistic: whether what matches gets the score 1."""

    thresholds: tuple[float, ...] = AP_THRESHOLDS
    min_region: int = 100
    strict: bool = True
    optimistic: bool = False


@dataclass(frozen=True, slots=True)
class Scene:
    """One evaluated scene of V vertices: truth (V,) instance ids and predicted ones, either ids (V,) or, where they may
    overlap, id -> vertex numbers; ids <= 0 are nobody's. scores of the predicted ids (1 where missing); classes of both
    kinds of ids, None for class-agnostic; void (V,) vertices that belong to no evaluated truth. Vertices nobody could
    see are left out beforehand."""

    truth: IntArray
    predicted: IntArray | Mapping[int, IntArray]
    scores: Mapping[int, float] = field(default_factory=dict)
    truth_classes: Mapping[int, Any] | None = None
    predicted_classes: Mapping[int, Any] | None = None
    void: BoolArray | None = None

    def overlaps(self) -> Overlaps:
        """What truths and predictions share."""
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
    what matched, which predictions double a truth that another one matched, and which truths were missed."""

    ap: float
    ap50: float
    ap25: float
    per_class: Mapping[Any, ClassAp]
    matches: tuple[Match, ...] = ()
    duplicates: tuple[int, ...] = ()
    missed: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class ClassJudgement:
    """One class of one scene: whether a truth is looked for, and the judgement at each threshold."""

    has_truth: bool
    at: Mapping[float, Judgement]


SceneJudgement = Mapping[Any, ClassJudgement]
"""All that is kept of a scene, by class: enough for its own AP and for one pooled with other scenes."""


def instance_ap(scene: Scene, settings: ApSettings | None = None) -> InstanceAp:
    """Evaluate one scene, with the details of what matched what."""
    settings = settings or ApSettings()
    overlaps = scene.overlaps()
    result = pooled([judge_scene(scene, overlaps, settings)], settings)
    found = find_matches(overlaps, scores_of(scene, overlaps), settings.min_region, settings.strict)
    return InstanceAp(result.ap, result.ap50, result.ap25, result.per_class, *found)


def pooled_instance_ap(scenes: Iterable[Scene], settings: ApSettings | None = None) -> InstanceAp:
    """Evaluate several scenes as the benchmark does: all their predictions in one ranking for each class."""
    settings = settings or ApSettings()
    return pooled([judge_scene(scene, scene.overlaps(), settings) for scene in scenes], settings)


def judge_scene(scene: Scene, overlaps: Overlaps, settings: ApSettings) -> SceneJudgement:
    """Judge every class that has a truth or a prediction in the scene."""
    agnostic = scene.truth_classes is None
    truth = _class_of(overlaps.truth_ids, scene.truth_classes)
    predicted = _class_of(overlaps.predicted_ids, None if agnostic else scene.predicted_classes or {})
    names = set(truth) | set(predicted) | set((scene.truth_classes or {}).values())
    scores = scores_of(scene, overlaps)
    judged = {}
    for name in sorted(names - {None}, key=str):
        rows, columns = (np.array([c == name for c in classes], np.bool_) for classes in (truth, predicted))
        judged[name] = _judge_class(overlaps.select(rows, columns), scores[columns], settings)
    return judged


def pooled(scenes: Sequence[SceneJudgement], settings: ApSettings) -> InstanceAp:
    """Average precision of judged scenes, all predictions of a class in one ranking."""
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
    known = [value for value in values if not np.isnan(value)]
    return float(np.mean(known)) if known else float("nan")


def scores_of(scene: Scene, overlaps: Overlaps) -> Float64Array:
    """The scores (P,) of the predictions, 1 where they have none."""
    return np.array([scene.scores.get(int(p), 1.0) for p in overlaps.predicted_ids], np.float64)


def _class_of(ids: Int64Array, classes: Mapping[int, Any] | None) -> list[Any]:
    return [ANY_CLASS if classes is None else classes.get(int(i)) for i in ids]


def _judge_class(overlaps: Overlaps, scores: Float64Array, settings: ApSettings) -> ClassJudgement:
    at = {}
    for threshold in {*settings.thresholds, 0.5, 0.25}:
        found = judge(overlaps, scores, threshold, settings.min_region, settings.strict)
        raised = np.where(found.right, 1.0, found.scores) if settings.optimistic else found.scores
        at[threshold] = Judgement(raised, found.right, found.missed, found.pairs)
    return ClassJudgement(bool((overlaps.truth_sizes >= settings.min_region).any()), at)


def _ap_at(parts: Sequence[ClassJudgement], threshold: float) -> float:
    """AP of one class at one threshold over all scenes: nan without truth, 0 without predictions."""
    if not any(part.has_truth for part in parts):
        return float("nan")
    return average_precision(*pooled_outcomes(parts, threshold))


def pooled_outcomes(parts: Sequence[ClassJudgement], threshold: float) -> tuple[Float64Array, BoolArray, int]:
    """Scores (N,), whether right (N,) and the number of missed truths of a class over scenes."""
    judged = [part.at[threshold] for part in parts]
    scores = np.concatenate([j.scores for j in judged])
    return scores, np.concatenate([j.right for j in judged]), sum(len(j.missed) for j in judged)
