"""Results of scenes brought together: pooled, or the mean of the scenes' numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from functools import reduce
from operator import add
from typing import Any

from razer.metrics.instance_ap import ANY_CLASS, InstanceAp, SceneJudgement, nanmean, pooled, pooled_outcomes
from razer.metrics.panoptic_quality import PanopticCounts, panoptic_quality
from razer.metrics.precision_recall import Curve, precision_recall
from razer.metrics.preset import Preset
from razer.metrics.retrieval import RetrievalCounts
from razer.metrics.scene_result import MAIN_LIST, InstanceResult
from razer.metrics.semantic import NONE, SemanticNumbers, kept_classes, semantic_numbers
from razer.metrics.surface import SurfaceNumbers
from razer.metrics.trajectory import TrajectoryNumbers

Numbers = dict[str, Any]
_AP_KEYS = ("ap", "ap50", "ap25")


def class_agnostic(results: Sequence[InstanceResult], preset: Preset) -> Numbers | None:
    """AP of all classes merged."""
    return (
        _ap(_over(lambda r: pooled([x.agnostic for x in r], preset.ap_settings), results, preset)) if results else None
    )


def class_aware(results: Sequence[InstanceResult], preset: Preset) -> Numbers | None:
    """AP by class, its means over the vocabulary's splits, and that of the preset's further lists of classes; None
    where the truth has no classes, or where there are predictions and none of them has a class."""
    results = [r for r in results if r.aware is not None]
    unnamed = not any(r.named for r in results) and any(r.n_predicted for r in results)
    if not results or unnamed:
        return None
    groups = {name: group for r in results for name, group in r.groups.items()}
    main = _aware_list(results, MAIN_LIST, preset, groups)
    return main | {"lists": {title: _aware_list(results, title, preset, groups) for title in preset.class_lists}}


def _aware_list(results: Sequence[InstanceResult], title: str, preset: Preset, groups: Mapping[str, str]) -> Numbers:
    def judged(part: Sequence[InstanceResult]) -> list[SceneJudgement]:
        return [r.aware[title] for r in part if r.aware is not None]

    found = _over(lambda part: pooled(judged(part), preset.ap_settings), results, preset)
    per_class = {str(name): asdict(numbers) for name, numbers in found[0].per_class.items()}
    if len(found) > 1:
        per_class = _mean_per_class(found)
    splits = {
        group: {key: nanmean(n[key] for name, n in per_class.items() if groups.get(name) == group) for key in _AP_KEYS}
        for group in sorted(set(groups.values()))
    }
    return _ap(found) | {"per_class": per_class, "splits": splits}


def _over(evaluate: Any, results: Sequence[InstanceResult], preset: Preset) -> list[InstanceAp]:
    """One evaluation of all scenes, or one of each."""
    if preset.instances_over_scenes == "pooled":
        return [evaluate(results)]
    return [evaluate([result]) for result in results]


def _ap(found: Sequence[InstanceAp]) -> Numbers:
    return {key: nanmean(getattr(one, key) for one in found) for key in _AP_KEYS}


def _mean_per_class(found: Sequence[InstanceAp]) -> dict[str, dict[str, float]]:
    names = sorted({name for one in found for name in one.per_class}, key=str)
    return {
        str(name): {
            key: nanmean(getattr(one.per_class[name], key) for one in found if name in one.per_class)
            for key in _AP_KEYS
        }
        for name in names
    }


def curves(results: Sequence[InstanceResult], aware: bool) -> dict[str, Curve]:
    """Precision over recall at an overlap of 0.5, of all classes merged and of each class that has a truth."""
    scenes = [r.agnostic for r in results]
    found = (
        {ANY_CLASS: precision_recall(*pooled_outcomes([s[ANY_CLASS] for s in scenes if ANY_CLASS in s], 0.5))}
        if any(scenes)
        else {}
    )
    by_class = [r.aware[MAIN_LIST] for r in results if aware and r.aware is not None]
    for name in sorted({name for scene in by_class for name in scene}, key=str):
        parts = [scene[name] for scene in by_class if name in scene]
        if any(part.has_truth for part in parts):
            found[str(name)] = precision_recall(*pooled_outcomes(parts, 0.5))
    return found


def panoptic(results: Sequence[InstanceResult], aware: bool, preset: Preset) -> Numbers | None:
    """Panoptic quality by class with things and stuff, and of instances of all classes merged. The first numbers are
    class-aware where there are classes."""
    if not results:
        return None
    agnostic = _panoptic_numbers([r.panoptic_agnostic for r in results], preset)
    by_class = _panoptic_numbers([r.panoptic_aware for r in results if r.panoptic_aware is not None], preset)
    agnostic.pop("per_class")
    main = by_class if aware else agnostic
    return main | {"classes": "aware" if aware else "agnostic", "class_agnostic": agnostic}


def _panoptic_numbers(counts: Sequence[Mapping[Any, PanopticCounts]], preset: Preset) -> Numbers:
    keys = ("pq", "sq", "rq")
    total = panoptic_quality(counts)
    per_class = {str(name): dict(zip(keys, values, strict=True)) for name, values in total.per_class.items()}
    each = [total] if preset.instances_over_scenes == "pooled" else [panoptic_quality([scene]) for scene in counts]
    return {key: nanmean(getattr(one, key) for one in each) for key in keys} | {"per_class": per_class}


def semantic(confusions: Sequence[Counter[tuple[str, str]]], preset: Preset) -> Numbers | None:
    """Semantic numbers by the preset's first list of classes left out, and by its further ones; None where no true
    class counts."""
    if not confusions:
        return None
    each = [reduce(add, confusions)] if preset.semantics_over_scenes == "pooled" else confusions
    titles: dict[str, Iterable[str] | None] = {MAIN_LIST: None, **preset.semantic_lists}
    found = {title: _semantic_list(each, preset, ignored) for title, ignored in titles.items()}
    main = found.pop(MAIN_LIST)
    return None if main is None else main | {"lists": found}


def _semantic_list(
    each: Sequence[Counter[tuple[str, str]]], preset: Preset, ignored: Iterable[str] | None
) -> Numbers | None:
    kept = kept_classes(preset, ignored)
    all_numbers = [semantic_numbers(one, kept, preset.count_ignored_points) for one in each]
    numbers = [n for n in all_numbers if n.per_class]
    keys = ("miou", "fmiou", "macc", "pixel_accuracy")
    means = {key: nanmean(getattr(n, key) for n in numbers) for key in keys}
    return means | {"per_class": _semantic_classes(numbers)} if numbers else None


def _semantic_classes(numbers: Sequence[SemanticNumbers]) -> dict[str, dict[str, float]]:
    names = sorted({name for one in numbers for name in one.per_class})
    parts = {name: [one.per_class[name] for one in numbers if name in one.per_class] for name in names}
    return {
        name: {"iou": nanmean(c.iou for c in found), "accuracy": nanmean(c.accuracy for c in found)}
        for name, found in parts.items()
    }


def confusion_table(confusions: Sequence[Counter[tuple[str, str]]]) -> Numbers | None:
    """names (C,), the first "" for none, and counts, C rows of C: true class by predicted class, over all scenes."""
    if not confusions:
        return None
    total = reduce(add, confusions)
    names = [NONE, *sorted({name for pair in total for name in pair} - {NONE})]
    return {"names": names, "counts": [[total[true, predicted] for predicted in names] for true in names]}


def surface(results: Sequence[SurfaceNumbers]) -> Numbers | None:
    """Mean over the scenes."""
    if not results:
        return None
    lengths = ("accuracy_m", "completeness_m", "chamfer_m")
    numbers: Numbers = {key: nanmean(getattr(r, key) for r in results) for key in lengths}
    for limit in results[0].fscore:
        for kind in ("fscore", "precision", "recall"):
            numbers[f"{kind}_{round(100 * limit)}cm"] = nanmean(getattr(r, kind)[limit] for r in results)
    return numbers | {"on_truth": all(r.on_truth for r in results)}


def retrieval(given: Sequence[RetrievalCounts], partners: Sequence[RetrievalCounts]) -> Numbers | None:
    """Top-1 of the truth's own masks and of the predicted ones, all scenes together."""
    if not given and not partners:
        return None
    return {"given_masks": _retrieval(given), "predicted_masks": _retrieval(partners)}


def _retrieval(counts: Sequence[RetrievalCounts]) -> Numbers | None:
    if not counts:
        return None
    total = reduce(add, counts)
    means = {"class_mean": total.class_mean, "instance_mean": total.instance_mean}
    return means | {"per_class": total.per_class, "asked": dict(total.asked)}


def pose(results: Sequence[TrajectoryNumbers]) -> Numbers | None:
    """Mean over the scenes."""
    if not results:
        return None
    each = [
        {
            "ate_rmse_m": r.ate_rmse_m,
            "rotation_rmse_deg": r.rotation_rmse_deg,
            "rpe_frame_m": r.per_frame.translation_m,
            "rpe_frame_deg": r.per_frame.rotation_deg,
            "rpe_second_m": r.per_second.translation_m,
            "rpe_second_deg": r.per_second.rotation_deg,
            "tracked": r.tracked,
        }
        for r in results
    ]
    means: Numbers = {key: nanmean(one[key] for one in each) for key in each[0]}
    return means | {"compared": sum(r.compared for r in results)}
