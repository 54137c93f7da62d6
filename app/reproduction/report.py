"""Reproduction report: the paper's table with the row of this run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich.console import Console
from rich.table import Table

from app.reproduction.component_times import NOTES, PER_FRAME, PUBLISHED_MS, STAGES_BY_COMPONENT
from app.reproduction.published_tables import PublishedTable
from app.reproduction.reproduce_table import Reproduced, Row

_MASKS = {"predicted_masks": "predicted masks", "given_masks": "the truth's masks"}


def report(result: Reproduced, published: PublishedTable, console: Console, poses: str | None = None) -> None:
    """Print the table, its footnotes, what failed, and where the time went; `poses` slam: beside the rows under
    estimated poses."""
    under = "estimated poses" if poses == "slam" else "given poses"
    console.print(_table(f"{published.title}, {under}", published.columns, published.rows_of(poses), result.row))
    for note in published.notes_of(poses):
        console.print(f"note: {note}", soft_wrap=True)
    console.print(f"preset {result.evaluation.preset.name}, {len(result.seconds)} scene(s) evaluated")
    for name, reason in result.failed.items():
        console.print(f"  {name} is not in it: {reason}", soft_wrap=True)
    for masks, numbers in result.retrieval.items():
        means = ", ".join(f"{key.replace('_', ' ')} {_text(value)} %" for key, value in numbers.items())
        console.print(f"retrieval, top-1, {_MASKS[masks]}: {means}", soft_wrap=True)
    _report_times(result, console)
    if published.has_component_times:
        _report_components(result, console)


def _report_times(result: Reproduced, console: Console) -> None:
    times = ", ".join(f"{name} {seconds:.1f} s" for name, seconds in result.seconds.items())
    console.print(f"time a scene: {times}", soft_wrap=True)
    stages = ", ".join(f"{name} {ms:.1f}" for name, ms in result.stages_ms.items())
    console.print(f"median ms a frame: {stages}", soft_wrap=True)


def _report_components(result: Reproduced, console: Console) -> None:
    columns, own = (*STAGES_BY_COMPONENT, PER_FRAME), tuple(result.components_ms.values())
    console.print(_table("mean ms a frame by component", columns, PUBLISHED_MS, own))
    for note in NOTES:
        console.print(f"note: {note}", soft_wrap=True)


def _table(title: str, columns: Sequence[str], rows: Mapping[str, Row], own: Row) -> Table:
    """Numbers of other systems by method, and ours in the last row."""
    table = Table(title=title, title_justify="left")
    table.add_column("method")
    for column in columns:
        table.add_column(column, justify="right")
    for method, row in rows.items():
        table.add_row(method, *map(_text, row))
    table.add_section()
    table.add_row("this run", *map(_text, own), style="bold")
    return table


def _text(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}" if value < 1 else f"{value:.1f}"
