"""Instance metrics aggregated over scenes: pooled in one ranking, or as the mean of the scenes' metrics."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from razer.metrics.instances.calibration import calibration
from razer.metrics.instances.instance_ap import (
    ANY_CLASS,
    InstanceAp,
    SceneOutcomes,
    nanmean,
    pooled_ap,
    pooled_outcomes,
)
from razer.metrics.instances.name_outcomes import naming_metrics
from razer.metrics.instances.panoptic_quality import PanopticCounts, panoptic_quality
from razer.metrics.instances.precision_recall import Curve, precision_recall
from razer.metrics.instances.prediction_account import PredictionAccount
from razer.metrics.instances.recall_by_views import recall_by_views
from razer.metrics.preset import Preset
from razer.metrics.protocol.scene_result import MAIN_LIST, InstanceResult

Metrics = dict[str, Any]
_AP_KEYS = ("ap", "ap50", "ap25")


def class_agnostic(results: Sequence[InstanceResult], preset: Preset) -> Metrics | None:
    """AP of all classes merged."""
    if not results:
        return None
    return _ap(_over(lambda part: pooled_ap([r.agnostic for r in part], preset.ap_settings), results, preset))


def class_aware(results: Sequence[InstanceResult], preset: Preset) -> Metrics | None:
    """AP by class, its means over the vocabulary's splits, and that of the preset's further lists of classes; None
    where the truth has no classes, or where there are predictions and none of them has a class."""
    results = [r for r in results if r.aware is not None]
    unnamed = not any(r.named for r in results) and any(r.n_predicted for r in results)
    if not results or unnamed:
        return None
    groups = {name: group for r in results for name, group in r.groups.items()}
    main = _aware_list(results, MAIN_LIST, preset, groups)
    return main | {"lists": {title: _aware_list(results, title, preset, groups) for title in preset.class_lists}}


def _aware_list(results: Sequence[InstanceResult], title: str, preset: Preset, groups: Mapping[str, str]) -> Metrics:
    def outcomes(part: Sequence[InstanceResult]) -> list[SceneOutcomes]:
        return [r.aware[title] for r in part if r.aware is not None]

    evaluations = _over(lambda part: pooled_ap(outcomes(part), preset.ap_settings), results, preset)
    per_class = {str(name): asdict(class_ap) for name, class_ap in evaluations[0].per_class.items()}
    if len(evaluations) > 1:
        per_class = _mean_per_class(evaluations)
    splits = {
        group: {key: nanmean(n[key] for name, n in per_class.items() if groups.get(name) == group) for key in _AP_KEYS}
        for group in sorted(set(groups.values()))
    }
    return _ap(evaluations) | {"per_class": per_class, "splits": splits}


def _over(
    evaluate: Callable[[Sequence[InstanceResult]], InstanceAp], results: Sequence[InstanceResult], preset: Preset
) -> list[InstanceAp]:
    """One evaluation of all scenes, or one of each."""
    if preset.instances_over_scenes == "pooled":
        return [evaluate(results)]
    return [evaluate([result]) for result in results]


def _ap(evaluations: Sequence[InstanceAp]) -> Metrics:
    return {key: nanmean(getattr(one, key) for one in evaluations) for key in _AP_KEYS}


def _mean_per_class(evaluations: Sequence[InstanceAp]) -> dict[str, dict[str, float]]:
    names = sorted({name for one in evaluations for name in one.per_class}, key=str)
    return {
        str(name): {
            key: nanmean(getattr(one.per_class[name], key) for one in evaluations if name in one.per_class)
            for key in _AP_KEYS
        }
        for name in names
    }


def curves(results: Sequence[InstanceResult], aware: bool) -> dict[str, Curve]:
    """Precision over recall at an overlap of 0.5, of all classes merged and of each class that has a truth."""
    scenes = [r.agnostic for r in results]
    curve_of = (
        {ANY_CLASS: precision_recall(*pooled_outcomes([s[ANY_CLASS] for s in scenes if ANY_CLASS in s], 0.5))}
        if any(scenes)
        else {}
    )
    by_class = [r.aware[MAIN_LIST] for r in results if aware and r.aware is not None]
    for name in sorted({name for scene in by_class for name in scene}, key=str):
        parts = [scene[name] for scene in by_class if name in scene]
        if any(part.has_truth for part in parts):
            curve_of[str(name)] = precision_recall(*pooled_outcomes(parts, 0.5))
    return curve_of


def panoptic(results: Sequence[InstanceResult], aware: bool, preset: Preset) -> Metrics | None:
    """Panoptic quality by class with things and stuff, and of instances of all classes merged. The main numbers are
    class-aware where there are classes."""
    if not results:
        return None
    agnostic = _panoptic_metrics([r.panoptic_agnostic for r in results], preset)
    by_class = _panoptic_metrics([r.panoptic_aware for r in results if r.panoptic_aware is not None], preset)
    agnostic.pop("per_class")
    main = by_class if aware else agnostic
    return main | {"classes": "aware" if aware else "agnostic", "class_agnostic": agnostic}


def _panoptic_metrics(counts: Sequence[Mapping[Any, PanopticCounts]], preset: Preset) -> Metrics:
    keys = ("pq", "sq", "rq")
    total = panoptic_quality(counts)
    per_class = {
        str(name): dict(zip(keys, values, strict=True)) | _segments(name, counts)
        for name, values in total.per_class.items()
    }
    each = [total] if preset.instances_over_scenes == "pooled" else [panoptic_quality([scene]) for scene in counts]
    return {key: nanmean(getattr(one, key) for one in each) for key in keys} | {"per_class": per_class}


def _segments(name: Any, counts: Sequence[Mapping[Any, PanopticCounts]]) -> dict[str, int]:
    """How many segments of a class are true, predicted and matched."""
    total = sum((scene[name] for scene in counts if name in scene), PanopticCounts())
    return {
        "n_true": total.true_positives + total.false_negatives,
        "n_predicted": total.true_positives + total.false_positives,
        "n_matched": total.true_positives,
    }


def prediction_counts(results: Sequence[InstanceResult]) -> Metrics:
    """How many true and predicted instances there are, and what became of the predicted ones: they add up."""
    if not results:
        return {}
    total = {name: sum(len(getattr(r.account, name)) for r in results) for name in PredictionAccount._fields}
    return {
        "n_true": sum(r.n_truth for r in results),
        "n_matched": total["matched"],
        "n_parts": total["parts"],
        "n_uncounted": total["uncounted"],
        "n_invented": total["invented"],
        "n_judged": sum(total.values()) - total["uncounted"],
    }


def calibration_of(results: Sequence[InstanceResult]) -> Metrics | None:
    """Calibration of the confidences of all predictions that are right or wrong; None where they have none."""
    if not results or any(r.confidences is None for r in results):
        return None
    pairs = [
        (confidences.get(number, 1.0), number in r.account.matched)
        for r in results
        if (confidences := r.confidences) is not None
        for number in (*r.account.matched, *r.account.wrong)
    ]
    return calibration(np.array([c for c, _ in pairs], np.float64), np.array([right for _, right in pairs], np.bool_))


def naming_of(results: Sequence[InstanceResult]) -> Metrics | None:
    """Accuracy and calibration of the names of matched instances; None where a prediction names nothing."""
    if not results or not any(r.named for r in results):
        return None
    return naming_metrics([outcome for r in results for outcome in r.names])


def views_table(results: Sequence[InstanceResult], n_frames: int) -> list[Metrics] | None:
    """Recall by views over scenes; None where the views of one are not known."""
    if not results or any(r.views is None for r in results):
        return None
    return recall_by_views((instance for r in results for instance in r.views or ()), n_frames)
