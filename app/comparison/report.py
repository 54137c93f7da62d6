"""Comparison report: tables of metrics and of matched instances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from app.comparison.compare_runs import Comparison
from app.comparison.folder import CONTENTS, SHEET
from app.comparison.matched_instances import MatchedInstance
from app.console.outputs import print_outputs
from app.evaluation.report import SUMMARY, format_number
from razer.map_object import MapObject

_MAX_PAIRS = 30
_MAX_UNMATCHED = 30
_POSE = {
    "ate_rmse_m": "ATE RMSE, m",
    "rotation_rmse_deg": "rotation RMSE, degrees",
    "rpe_trans_m": "RPE a frame, m",
    "rpe_rot_deg": "RPE a frame, degrees",
    "rpe_second_trans_m": "RPE a second, m",
    "rpe_second_rot_deg": "RPE a second, degrees",
    "compared": "poses compared",
    "tracked_a": "share of frames tracked in A",
    "tracked_b": "share of frames tracked in B",
}
_COUNTS = {"n_predicted": "instances", "missed": "missed of the truth", "duplicates": "duplicates"}


def report(result: Comparison, console: Console, folder: Path) -> None:
    """Print both sides against the truth, where there is one, B against A, and the instances pair by pair."""
    content = result.as_json()
    console.print(f"A: {result.a.name}   B: {result.b.name}", soft_wrap=True)
    if content["a"] is not None:
        console.print(_against_truth(content))
    console.print(_b_against_a(content))
    for side, run in (("A", result.a), ("B", result.b)):
        if run.account is not None:
            console.print(f"{side}: {run.account.describe()}")
        if run.corrections is not None:
            console.print(f"{side}: {run.corrections.describe()}", soft_wrap=True, highlight=False)
    console.print(f"maps aligned by {result.alignment.describe()}", soft_wrap=True)
    if (pose := content["pose"]) is not None:
        _print_poses(pose, console)
    _print_instances(result, console)
    console.print(f"picture: {folder / SHEET}", soft_wrap=True)
    print_outputs(folder, CONTENTS, console)


def _print_poses(pose: Mapping[str, Any], console: Console) -> None:
    _print_transform("A from B, of the maps:", pose["a_from_b"], console)
    _print_transform("A from B, of the positions alone (ATE):", pose["a_from_b_by_positions"], console)


def _print_transform(title: str, rows: Sequence[Sequence[float]], console: Console) -> None:
    console.print(title)
    for row in rows:
        console.print("  " + " ".join(f"{value:10.6f}" for value in row))


def _against_truth(content: Mapping[str, Any]) -> Table:
    table = Table(title=f"against the truth, preset {content['preset']}", title_justify="left")
    for name in ("number", "A", "B", "B - A"):
        table.add_column(name, justify="left" if name == "number" else "right")
    sides = [content[side] for side in ("a", "b", "delta")]
    for part, labels in SUMMARY.items():
        for key, label in labels.items():
            values = [(side[part] or {}).get(key) for side in sides]
            if any(value is not None for value in values):
                table.add_row(label, *map(format_number, values))
    for key, label in _COUNTS.items():
        table.add_row(label, *(format_number(side[key]) for side in sides))
    return table


def _b_against_a(content: Mapping[str, Any]) -> Table:
    table = Table(title="B against A", title_justify="left")
    table.add_column("number")
    table.add_column("value", justify="right")
    for part, labels in (("pose", _POSE), ("surface", SUMMARY["surface"])):
        for key, label in labels.items():
            table.add_row(label, format_number((content[part] or {}).get(key)))
    return table


def _print_instances(result: Comparison, console: Console) -> None:
    matching = result.instances
    table = Table(title=f"{len(matching.matched)} instances in both", title_justify="left")
    for name in ("A", "B", "class", "IoU", "apart, m", "A, cm", "B, cm", "cosine"):
        table.add_column(name, justify="left" if name == "class" else "right")
    for match in sorted(matching.matched, key=lambda match: match.iou)[:_MAX_PAIRS]:
        table.add_row(*_row(match))
    if matching.matched:
        console.print(table)
    if len(matching.matched) > _MAX_PAIRS:
        console.print(f"and {len(matching.matched) - _MAX_PAIRS} that agree better: --json has them all")
    for what, unmatched in (("missed, in A alone", matching.missed), ("extra, in B alone", matching.extra)):
        console.print(f"{len(unmatched)} {what}{_listed(unmatched)}", soft_wrap=True)


def _row(match: MatchedInstance) -> tuple[str, ...]:
    a, b = match.a, match.b
    names = [instance.class_name or "-" for instance in (a, b)]
    sizes = ("x".join(f"{100 * edge:.0f}" for edge in sorted(instance.box.extent, reverse=True)) for instance in (a, b))
    cosine = "-" if match.cosine is None else f"{match.cosine:.3f}"
    kind = names[0] if names[0] == names[1] else " / ".join(names)
    return str(a.id), str(b.id), kind, f"{match.iou:.2f}", f"{match.center_distance_m:.3f}", *sizes, cosine


def _listed(objects: tuple[MapObject, ...]) -> str:
    if not objects:
        return ""
    shown = ", ".join(f"{o.id} {o.class_name or ''}".rstrip() for o in objects[:_MAX_UNMATCHED])
    return f": {shown}" + (f" and {len(objects) - _MAX_UNMATCHED} more" if len(objects) > _MAX_UNMATCHED else "")
