"""The bank beside a running mean and beside vectors without noise, in retrieval by text."""

from __future__ import annotations

from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from app.evaluation.exemplars import Exemplars
from app.evaluation.query_protocol import (
    Protocol,
    QueryScore,
    banks_of,
    clean_banks,
    observed,
    presence_at,
    presence_curve,
    query_score,
)
from app.running.progress import watch
from razer.config import BankSettings

SHARES = {"own observations": 0.0, "a third of a neighbour": 1 / 3}
BANKS = {"bank": BankSettings(), "running mean": BankSettings(hypotheses=1)}
RECALLS = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
Scores = dict[str, list[QueryScore]]


def measure_queries(exemplars: Exemplars, draws: int, console: Console) -> Scores:
    """The scores of each bank under each kind of observations, one for each draw."""
    result: Scores = {}
    for draw in watch(range(draws), draws, lambda: "", console):
        rng = np.random.default_rng(draw)
        present, absent = exemplars.present_and_absent(Protocol.n_objects, rng)
        banks = {"without noise": clean_banks(exemplars, present)}
        for kind, share in SHARES.items():
            observations = observed(exemplars, present, rng, Protocol(of_neighbour=share))
            banks |= {f"{name}, {kind}": banks_of(observations, settings) for name, settings in BANKS.items()}
        for name, bank in banks.items():
            result.setdefault(name, []).append(query_score(exemplars, bank, present, absent))
    return result


def figures(scores: list[QueryScore]) -> dict[str, Any]:
    """Means over draws, precision and recall of the answer "present", and precision at some recalls."""
    curve, (precision, recall) = presence_curve(scores), presence_at(scores)
    means = {part: float(np.mean([getattr(s, part) for s in scores])) for part in ("top1", "top5", "text_top1")}
    at = {f"{level:g}": float(curve.precision[curve.recall >= level].max()) for level in RECALLS}
    return {**means, "present_precision": precision, "present_recall": recall, "precision_at_recall": at}


def query_table(rows: dict[str, dict[str, Any]], title: str) -> Table:
    """Percentages, a row for each bank."""
    table = Table(title=title, title_justify="left")
    table.add_column("bank")
    heads = ("name top-1", "top-5", "text top-1", "present: precision", "recall")
    for head in (*heads, *(f"P at R {level:g}" for level in RECALLS)):
        table.add_column(head, justify="right")
    for name, row in rows.items():
        parts = ("top1", "top5", "text_top1", "present_precision", "present_recall")
        values = (*(row[part] for part in parts), *row["precision_at_recall"].values())
        table.add_row(name, *(f"{100 * value:.1f}" for value in values))
    return table
