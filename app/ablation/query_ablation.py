"""Ablation of the embedding bank in retrieval by text: beside a running mean and beside vectors without noise."""

from __future__ import annotations

from typing import Any

import numpy as np
from rich.table import Table

from app.ablation.exemplars import Exemplars
from app.ablation.query_protocol import (
    Protocol,
    QueryScore,
    banks_of,
    clean_banks,
    noisy_observations,
    presence_at,
    presence_curve,
    query_score,
)
from razer.config import BankSettings

# Share of an object's observations that are of another object.
NEIGHBOUR_SHARES = {"own": 0.0, "with neighbour": 1 / 3}
BANKS = {"bank": BankSettings(), "mean": BankSettings(hypotheses=1)}
RECALLS = (0.6, 0.7, 0.8, 0.9)
MEANS = {"top1": "name top-1", "top5": "top-5", "cosine_top1": "top-1 by cosine", "text_top1": "text top-1"}


def measure_queries(exemplars: Exemplars, draws: int) -> dict[str, list[QueryScore]]:
    """The scores of each bank under each kind of observations, one for each draw."""
    result: dict[str, list[QueryScore]] = {}
    for draw in range(draws):
        rng = np.random.default_rng(draw)
        present, absent = exemplars.present_and_absent(Protocol.n_objects, rng)
        banks = {"without noise": clean_banks(exemplars, present)}
        for kind, share in NEIGHBOUR_SHARES.items():
            observations = noisy_observations(exemplars, present, rng, Protocol(neighbour_share=share))
            banks |= {f"{name}, {kind}": banks_of(observations, settings) for name, settings in BANKS.items()}
        for name, bank in banks.items():
            result.setdefault(name, []).append(query_score(exemplars, bank, present, absent))
    return result


def mean_scores(scores: list[QueryScore]) -> dict[str, Any]:
    """Means over draws, precision and recall of the answer "present", and precision at some recalls."""
    curve, (precision, recall) = presence_curve(scores), presence_at(scores)
    means = {part: float(np.mean([getattr(s, part) for s in scores])) for part in MEANS}
    at = {f"{level:g}": float(curve.precision[curve.recall >= level].max()) for level in RECALLS}
    return {**means, "present_precision": precision, "present_recall": recall, "precision_at_recall": at}


def retrieval_table(rows: dict[str, dict[str, Any]]) -> Table:
    """How often the right name or instance comes first, percent, a row for each bank."""
    values = {name: [row[part] for part in MEANS] for name, row in rows.items()}
    return _percentages(list(MEANS.values()), values, "names of instances, instances of texts, %")


def presence_table(rows: dict[str, dict[str, Any]]) -> Table:
    """Precision and recall of the answer "present", percent, and precision over recall."""
    heads = ["P", "R", *(f"R {level:g}" for level in RECALLS)]
    values = {
        name: [row["present_precision"], row["present_recall"], *row["precision_at_recall"].values()]
        for name, row in rows.items()
    }
    return _percentages(
        heads, values, "answer 'present': its precision P and recall R, and precision at other recalls, %"
    )


def _percentages(heads: list[str], rows: dict[str, list[float]], title: str) -> Table:
    table = Table(title=title, title_justify="left")
    table.add_column("bank, observations")
    for head in heads:
        table.add_column(head, justify="right")
    for name, values in rows.items():
        table.add_row(name, *(f"{100 * value:.1f}" for value in values))
    return table
