"""Reproduction report: the paper's table with the row of this run."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from app.reproduction.published_tables import PublishedTable
from app.reproduction.reproduce_table import Reproduced, Row


def report(result: Reproduced, published: PublishedTable, console: Console) -> None:
    """Print the table, its footnotes, what failed, and where the time went."""
    table = Table(title=published.title, title_justify="left")
    table.add_column("method")
    for column in published.columns:
        table.add_column(column, justify="right")
    for method, row in published.rows.items():
        table.add_row(method, *_texts(row))
    table.add_section()
    table.add_row("this run", *_texts(result.row), style="bold")
    console.print(table)
    for note in published.notes:
        console.print(f"note: {note}", soft_wrap=True)
    console.print(f"preset {result.evaluation.preset.name}, {len(result.seconds)} scene(s) evaluated")
    for name, reason in result.failed.items():
        console.print(f"  {name} is not in it: {reason}", soft_wrap=True)
    times = ", ".join(f"{name} {seconds:.1f} s" for name, seconds in result.seconds.items())
    console.print(f"time a scene: {times}", soft_wrap=True)
    stages = ", ".join(f"{name} {ms:.1f}" for name, ms in result.stages_ms.items())
    console.print(f"median ms a frame: {stages}", soft_wrap=True)


def _texts(row: Row) -> list[str]:
    return ["-" if value is None else f"{value:.3f}" if value < 1 else f"{value:.1f}" for value in row]
