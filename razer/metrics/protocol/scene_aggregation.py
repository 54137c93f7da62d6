"""Semantic, surface, retrieval and pose metrics aggregated over scenes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from functools import reduce
from operator import add
from typing import Any

from razer.metrics.instances.instance_ap import nanmean
from razer.metrics.instances.retrieval import RetrievalCounts
from razer.metrics.preset import Preset
from razer.metrics.semantic_segmentation import NONE, SemanticMetrics, kept_classes, semantic_metrics
from razer.metrics.surface.surface_errors import SurfaceMetrics
from razer.metrics.trajectory_errors import TrajectoryMetrics

Metrics = dict[str, Any]
_FIRST = ""


def semantic(confusions: Sequence[Counter[tuple[str, str]]], preset: Preset) -> Metrics | None:
    """Semantic metrics by the preset's first list of classes left out, and by its further ones; None where no true
    class counts."""
    if not confusions:
        return None
    each = [reduce(add, confusions)] if preset.semantics_over_scenes == "pooled" else confusions
    titles: dict[str, Iterable[str] | None] = {_FIRST: None, **preset.semantic_lists}
    by_list = {title: _semantic_list(each, preset, ignored) for title, ignored in titles.items()}
    main = by_list.pop(_FIRST)
    return None if main is None else main | {"lists": by_list}


def _semantic_list(
    each: Sequence[Counter[tuple[str, str]]], preset: Preset, ignored: Iterable[str] | None
) -> Metrics | None:
    is_kept = kept_classes(preset, ignored)
    all_numbers = [semantic_metrics(one, is_kept, preset.count_ignored_points) for one in each]
    numbers = [n for n in all_numbers if n.per_class]
    keys = ("miou", "fmiou", "macc", "pixel_accuracy")
    means = {key: nanmean(getattr(n, key) for n in numbers) for key in keys}
    return means | {"per_class": _semantic_classes(numbers)} if numbers else None


def _semantic_classes(numbers: Sequence[SemanticMetrics]) -> dict[str, dict[str, float]]:
    names = sorted({name for one in numbers for name in one.per_class})
    parts = {name: [one.per_class[name] for one in numbers if name in one.per_class] for name in names}
    return {
        name: {"iou": nanmean(c.iou for c in scenes), "accuracy": nanmean(c.accuracy for c in scenes)}
        for name, scenes in parts.items()
    }


def confusion_table(confusions: Sequence[Counter[tuple[str, str]]]) -> Metrics | None:
    """names (C,), the first "" for none, and counts, C rows of C: true class by predicted class, over all scenes."""
    if not confusions:
        return None
    total = reduce(add, confusions)
    names = [NONE, *sorted({name for pair in total for name in pair} - {NONE})]
    return {"names": names, "counts": [[total[true, predicted] for predicted in names] for true in names]}


def surface(results: Sequence[SurfaceMetrics]) -> Metrics | None:
    """Mean over the scenes."""
    if not results:
        return None
    lengths = ("accuracy_m", "completeness_m", "chamfer_m")
    numbers: Metrics = {key: nanmean(getattr(r, key) for r in results) for key in lengths}
    for limit in results[0].fscore:
        for kind in ("fscore", "precision", "recall"):
            numbers[f"{kind}_{round(100 * limit)}cm"] = nanmean(getattr(r, kind)[limit] for r in results)
    return numbers | {"on_truth": all(r.on_truth for r in results)}


def retrieval(given: Sequence[RetrievalCounts], partners: Sequence[RetrievalCounts]) -> Metrics | None:
    """Top-1 of the truth's own masks and of the predicted ones, all scenes together."""
    if not given and not partners:
        return None
    return {"given_masks": _retrieval(given), "predicted_masks": _retrieval(partners)}


def _retrieval(counts: Sequence[RetrievalCounts]) -> Metrics | None:
    if not counts:
        return None
    total = reduce(add, counts)
    means = {"class_mean": total.class_mean, "instance_mean": total.instance_mean}
    return means | {"per_class": total.per_class, "asked": dict(total.asked)}


def pose(results: Sequence[TrajectoryMetrics]) -> Metrics | None:
    """Mean over the scenes; degenerate: why positions hardly fix the alignment that ATE stands on, if so."""
    if not results:
        return None
    each = [_pose_of_scene(result) for result in results]
    means: Metrics = {key: nanmean(scene[key] for scene in each) for key in each[0]}
    degenerate = sorted({cause for r in results if (cause := r.by_positions.degenerate) is not None})
    return means | {"compared": sum(r.compared for r in results), "degenerate": degenerate}


def _pose_of_scene(result: TrajectoryMetrics) -> dict[str, float]:
    return {
        "ate_rmse_m": result.ate_rmse_m,
        "rotation_rmse_deg": result.rotation_rmse_deg,
        "rpe_frame_m": result.per_frame.translation_m,
        "rpe_frame_deg": result.per_frame.rotation_deg,
        "rpe_second_m": result.per_second.translation_m,
        "rpe_second_deg": result.per_second.rotation_deg,
        "tracked": result.tracked,
    }
