"""Evaluation report: tables of rules, metrics, classes and the worst misses."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from razer.metrics.protocol.evaluation import Evaluation

_MAX_CLASSES = 30
_MAX_WORST = 8
# Part of an evaluation -> its numbers and what a table calls them.
SUMMARY = {
    "class_agnostic": {"ap": "AP", "ap50": "AP50", "ap25": "AP25"},
    "class_aware": {"ap": "AP by class", "ap50": "AP50 by class", "ap25": "AP25 by class"},
    "panoptic": {"pq": "PQ", "sq": "SQ", "rq": "RQ"},
    "semantic": {"miou": "mIoU", "fmiou": "F-mIoU", "macc": "mAcc", "pixel_accuracy": "pixel accuracy"},
    "relations": {
        "precision": "precision of relations",
        "recall": "recall of relations",
        "ends_found": "true relations with both ends found",
    },
    "surface": {
        "accuracy_m": "accuracy, m",
        "completeness_m": "completeness, m",
        "fscore_2cm": "F-score 2 cm",
        "fscore_5cm": "F-score 5 cm",
    },
    "pose": {
        "ate_rmse_m": "ATE RMSE, m",
        "rotation_rmse_deg": "rotation RMSE, degrees",
        "rpe_frame_m": "RPE a frame, m",
        "rpe_frame_deg": "RPE a frame, degrees",
        "rpe_second_m": "RPE a second, m",
        "rpe_second_deg": "RPE a second, degrees",
        "tracked": "share of frames tracked",
    },
}


def report(result: Evaluation, console: Console) -> None:
    """Print the rules, the metrics, the classes and the true instances matched worst."""
    _print_rules(result, console)
    table = Table(title=f"{len(result.scenes)} scene(s)", title_justify="left")
    table.add_column("number")
    table.add_column("value", justify="right")
    for part, labels in SUMMARY.items():
        numbers: Mapping[str, Any] | None = getattr(result, part)
        for key, label in labels.items():
            if numbers is not None and key in numbers:
                table.add_row(label, format_number(numbers[key]))
    for split, numbers in ((result.class_aware or {}).get("splits") or {}).items():
        table.add_row(f"AP {split}", format_number(numbers["ap"] if isinstance(numbers, Mapping) else numbers))
    for row in (result.retrieval or {}).items():
        _add_flat(table, "retrieval", row)
    console.print(table)
    if result.n_true is not None:
        console.print(counts_in_words(result), soft_wrap=True)
    if result.recall_by_views:
        console.print(f"found, by frames that show it: {_views_in_words(result.recall_by_views)}", soft_wrap=True)
    if result.calibration is not None:
        error = format_number(result.calibration["ece"])
        console.print(f"confidences differ from the share that is right by {error} on average (ECE)", soft_wrap=True)
    if result.naming is not None:
        console.print(naming_in_words(result.naming), soft_wrap=True)
    _print_ids(result, console)
    _print_classes(result, console)
    _print_worst(result, console)


def naming_in_words(naming: Mapping[str, Any]) -> str:
    """How many names are right, and how far their probabilities are off."""
    error = naming["ece"]
    calibrated = "" if error is None else f"; their probabilities are off by {format_number(error)} on average (ECE)"
    return f"names of matched instances: {naming['accuracy']:.1%} of {naming['n']} right{calibrated}"


def counts_in_words(result: Evaluation) -> str:
    """What became of true and predicted instances; the numbers of the predicted ones add up."""
    parts = [
        f"{result.n_true} true, {result.n_predicted} predicted: {result.n_matched} matched",
        f"{result.missed} missed",
        f"{result.duplicates} pieces of matched ones",
        f"{result.n_invented} on nothing",
    ]
    if result.n_parts:
        parts.insert(3, f"{result.n_parts} parts of missed ones or of several")
    if result.n_uncounted:
        parts.append(f"{result.n_uncounted} on walls and other surface that does not count")
    return ", ".join(parts)


def _views_in_words(bins: Sequence[Mapping[str, Any]]) -> str:
    ranges = [(f"{low}" if low == high else f"{low}-{high}", part) for part in bins for low, high in (part["views"],)]
    return ", ".join(f"{views}: {round(part['recall50'] * part['n'])} of {part['n']}" for views, part in ranges)


def _print_rules(result: Evaluation, console: Console) -> None:
    rules = result.preset.model_dump(exclude={"name", "source", "scenes"}, exclude_defaults=True)
    changed = "; ".join(f"{name} {value}" for name, value in rules.items()) or "all rules as by default"
    console.print(f"preset {result.preset.name}: {result.preset.source}", soft_wrap=True)
    console.print(f"  {changed}", soft_wrap=True, highlight=False)
    preset = result.preset
    thresholds = f"AP at IoU {preset.thresholds[0]:.2f} to {preset.thresholds[-1]:.2f}"
    instances = f"score '{preset.score}', instances within {preset.instance_max_m} m"
    console.print(
        f"  {thresholds}, at least {preset.min_region} vertices, {instances}, "
        f"classes of {preset.semantic_k} neighbour(s)",
        soft_wrap=True,
    )


def _add_flat(table: Table, name: str, row: tuple[str, Any]) -> None:
    key, value = row
    if key in ("per_class", "asked"):
        return
    if isinstance(value, Mapping):
        for inner in value.items():
            _add_flat(table, f"{name} {key.replace('_', ' ')}", inner)
    elif isinstance(value, int | float):
        table.add_row(f"{name} {key.replace('_', ' ')}", format_number(value))


def _print_ids(result: Evaluation, console: Console) -> None:
    for name, numbers in result.scenes.items():
        for what in ("missed", "duplicates"):
            if ids := numbers.get(what):
                console.print(f"  {name}: {what} {' '.join(str(i) for i in ids)}", soft_wrap=True, highlight=False)


def _print_classes(result: Evaluation, console: Console) -> None:
    aware: Mapping[str, Any] = (result.class_aware or {}).get("per_class") or {}
    panoptic: Mapping[str, Any] = (result.panoptic or {}).get("per_class") or {}
    names = sorted({*aware, *panoptic})
    if not aware:
        return
    table = Table(title=f"{len(names)} classes", title_justify="left")
    table.add_column("class")
    for key in ("true", "predicted", "AP", "AP50", "AP25", "PQ"):
        table.add_column(key, justify="right")
    for name in names[:_MAX_CLASSES]:
        table.add_row(name, *_class_row(aware.get(name, {}), panoptic.get(name, {})))
    console.print(table)
    if len(names) > _MAX_CLASSES:
        console.print(f"and {len(names) - _MAX_CLASSES} more: --json has them all")


def _class_row(aware: Mapping[str, Any], panoptic: Mapping[str, Any]) -> list[str]:
    counts = [str(panoptic.get(key, "-")) for key in ("n_true", "n_predicted")]
    return [
        *counts,
        *(format_number(aware.get(key)) for key in ("ap", "ap50", "ap25")),
        format_number(panoptic.get("pq")),
    ]


def _print_worst(result: Evaluation, console: Console) -> None:
    if not result.worst:
        return
    table = Table(title="matched worst", title_justify="left")
    for name in ("scene", "true id", "class", "vertices", "nearest prediction", "its class", "IoU"):
        table.add_column(name)
    for miss in result.worst[:_MAX_WORST]:
        partner = "-" if miss.predicted is None else str(miss.predicted)
        classes = (miss.truth_class or "-", miss.predicted_class or "-")
        table.add_row(
            miss.scene, str(miss.truth), classes[0], str(miss.vertices), partner, classes[1], f"{miss.iou:.2f}"
        )
    console.print(table)


def format_number(value: Any) -> str:
    """A number in four digits, "-" for none; what rounds to less than 0.0001 is 0."""
    if value is None or not math.isfinite(value):
        return "-"
    if abs(value) < 1e-4:
        value = round(value, 4) + 0.0  # no minus before a zero
    return f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"
