"""The evaluator: pairs of ground truth and prediction in, all metrics of the protocols out."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from razer.metrics.instances.precision_recall import Curve
from razer.metrics.instances.worst_instances import WorstInstance, worst_of
from razer.metrics.preset import Preset
from razer.metrics.protocol import instance_aggregation, scene_aggregation
from razer.metrics.protocol.scene_overlap import NEAR_M, is_of_another_scene
from razer.metrics.protocol.scene_result import SceneResult, evaluate_scene
from razer.metrics.relation_scores import relation_scores
from razer.metrics.scene_pair import PredictedScene, TruthScene

Pair = tuple[str, TruthScene, PredictedScene]
Metrics = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Evaluation:
    """All metrics of one evaluation, by the preset's rules. Parts that do not apply are None, metrics without a value
    (a class without truth) nan.

    duplicates, missed, n_...: instances, regardless of class, at an overlap of 0.5; n_true (also n_truth) = n_matched
    + missed; n_predicted = n_matched + duplicates + n_parts + n_uncounted + n_invented, as in `PredictionAccount`;
    n_judged = n_predicted - n_uncounted.
    recall_by_views, calibration, naming: of the same matches. curves: precision over recall at 0.5 by class, "any" for
    all merged. confusion: names (C,), "" for none, and counts, C rows of C, true by predicted class. scenes: the same
    metrics of each scene, with the ids of matches, duplicates, inventions and misses. warnings: what makes the numbers
    doubtful, in words."""

    preset: Preset
    class_agnostic: Metrics | None = None
    class_aware: Metrics | None = None
    semantic: Metrics | None = None
    panoptic: Metrics | None = None
    surface: Metrics | None = None
    duplicates: int | None = None
    missed: int | None = None
    pose: Metrics | None = None
    n_truth: int | None = None
    n_predicted: int | None = None
    n_true: int | None = None
    n_matched: int | None = None
    n_parts: int | None = None
    n_uncounted: int | None = None
    n_invented: int | None = None
    n_judged: int | None = None
    recall_by_views: Sequence[Metrics] | None = None
    calibration: Metrics | None = None
    naming: Metrics | None = None
    retrieval: Metrics | None = None
    relations: Metrics | None = None
    confusion: Metrics | None = None
    worst: tuple[WorstInstance, ...] = ()
    unknown_names: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    scenes: Mapping[str, Metrics] = field(default_factory=dict)
    curves: Mapping[str, Curve] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """The machine-readable contract: plain JSON values only, null where a part does not apply or is no number."""
        parts = {
            name: getattr(self, name) for name in Evaluation.__slots__ if name not in ("preset", "curves", "worst")
        }
        worst = [asdict(one) for one in self.worst]
        return plain_json({"preset": self.preset.name, "settings": self.preset.model_dump(), **parts, "worst": worst})


def evaluate(pairs: Iterable[Pair], preset: Preset) -> Evaluation:
    """Evaluate (name, truth, prediction) scene by scene by the preset's rules; only one scene is held at a time, of
    which match outcomes and counts are kept."""
    results: list[SceneResult] = []
    for name, truth, predicted in pairs:
        results.append(evaluate_scene(name, truth, predicted, preset))
        del truth, predicted
    return pooled(results, preset)


def pooled(results: Sequence[SceneResult], preset: Preset) -> Evaluation:
    """The metrics of scenes that were evaluated one by one, wherever, all by this preset's rules."""
    return _summary(results, preset, {result.name: _scene_metrics(result, preset) for result in results})


_SCENE_METRICS = ("class_agnostic", "class_aware", "semantic", "panoptic", "surface", "retrieval", "relations", "pose")
_SCENE_COUNTS = ("n_truth", "n_predicted", "n_true", "n_matched", "n_parts", "n_uncounted", "n_invented", "n_judged")


def _scene_metrics(result: SceneResult, preset: Preset) -> Metrics:
    """The metrics of one scene, without tables by class."""
    evaluation = _summary([result], preset, {})
    metrics: dict[str, Any] = {name: _without_tables(getattr(evaluation, name)) for name in _SCENE_METRICS}
    counts = {name: getattr(evaluation, name) for name in _SCENE_COUNTS}
    views = {"recall_by_views": evaluation.recall_by_views, "calibration": evaluation.calibration}
    views["naming"] = evaluation.naming
    overlap = None if result.overlap is None else result.overlap._asdict()
    return metrics | counts | views | {"overlap": overlap} | _ids(result)


def _ids(result: SceneResult) -> dict[str, Any]:
    if result.instances is None:
        return {"matches": []}
    summary, account = result.instances.match_summary, result.instances.account
    ids = {"duplicates": summary.duplicates, "missed": summary.missed, "invented": account.invented}
    return ids | {"matches": [match._asdict() for match in summary.matches]}


def _without_tables(metrics: Metrics | None) -> Metrics | None:
    if metrics is None:
        return None
    return {key: value for key, value in metrics.items() if key not in ("per_class", "splits", "lists")}


def _summary(results: Sequence[SceneResult], preset: Preset, scenes: Mapping[str, Metrics]) -> Evaluation:
    instances = [r.instances for r in results if r.instances is not None]
    confusions = [r.confusion for r in results if r.confusion is not None]
    aware = instance_aggregation.class_aware(instances, preset)
    summaries = [r.match_summary for r in instances]
    return Evaluation(
        preset=preset,
        class_agnostic=instance_aggregation.class_agnostic(instances, preset),
        class_aware=aware,
        semantic=scene_aggregation.semantic(confusions, preset),
        panoptic=instance_aggregation.panoptic(instances, aware is not None, preset),
        surface=scene_aggregation.surface([r.surface for r in results if r.surface is not None]),
        duplicates=sum(len(s.duplicates) for s in summaries) if summaries else None,
        missed=sum(len(s.missed) for s in summaries) if summaries else None,
        pose=scene_aggregation.pose([r.pose for r in results if r.pose is not None]),
        n_truth=sum(r.n_truth for r in instances) if instances else None,
        n_predicted=sum(r.n_predicted for r in instances) if instances else None,
        **instance_aggregation.prediction_counts(instances),
        recall_by_views=instance_aggregation.views_table(instances, max((r.n_frames for r in results), default=0)),
        calibration=instance_aggregation.calibration_of(instances),
        naming=instance_aggregation.naming_of(instances),
        retrieval=scene_aggregation.retrieval(
            [r.retrieval_given for r in results if r.retrieval_given is not None],
            [r.retrieval_partners for r in results if r.retrieval_partners is not None],
        ),
        relations=relation_scores([r.relations for r in results if r.relations is not None]),
        confusion=scene_aggregation.confusion_table(confusions),
        worst=worst_of((w for r in instances for w in r.worst), preset.worst),
        unknown_names=tuple(sorted({name for r in results for name in r.unknown_names})),
        warnings=tuple(w for r in results for w in _warnings(r)),
        scenes=scenes,
        curves=instance_aggregation.curves(instances, aware is not None),
    )


def _warnings(result: SceneResult) -> list[str]:
    """What makes the numbers of a scene doubtful."""
    counts = result.instances
    n_matched, n_truth = (None, None) if counts is None else (len(counts.match_summary.matches), counts.n_truth)
    overlap = result.overlap
    if overlap is None or not is_of_another_scene(overlap, n_matched, n_truth):
        return []
    return [
        f"{result.name}: only {overlap.predicted:.0%} of the map lie within {100 * NEAR_M:.0f} cm of the truth, and "
        f"{overlap.truth:.0%} of the truth within that of the map: a map of another scene, or in another frame"
    ]


def plain_json(value: Any) -> Any:
    """The value with only what JSON has: nan and infinity become None, keys text, tuples lists."""
    if isinstance(value, Mapping):
        return {str(key): plain_json(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain_json(part) for part in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value
