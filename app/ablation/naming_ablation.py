"""Ablation of naming on finished runs: by votes, by embeddings, by both, and by weights fitted to these very runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
from rich.table import Table
from scipy.optimize import minimize

from app.ablation.matched_run import MatchedRun
from razer.arrays import BoolArray, Float64Array, IndexArray
from razer.errors import BadInput
from razer.metrics.instances.calibration import calibration
from razer.query.name_probability import NameParts, NameWeights

# What is left of the weights in each rule; None: fitted.
RULES: Mapping[str, NameWeights | None] = {
    "votes alone": NameWeights(alike=0.0, vectors=0.0),
    "embeddings alone": NameWeights(said=0.0, alike=0.0),
    "votes and likeness": NameWeights(vectors=0.0),
    "votes and embeddings": NameWeights(alike=0.0),
    "as is": NameWeights(),
    "fitted": None,
}


@dataclass(frozen=True)
class NamedThings:
    """The things of a run that stand for a true one: the parts of the probabilities of all names of the truth, and
    which name (K,) is theirs."""

    parts: NameParts
    right: IndexArray

    @classmethod
    def of(cls, run: MatchedRun) -> NamedThings:
        """Those of a finished run."""
        row = {int(i): number for number, i in enumerate(run.panoptic.embedding_table.ids)}
        column = {name: number for number, name in enumerate(run.names)}
        found = [(row[i], column[name]) for i, name in run.true_names.items()]
        rows, right = np.array(found, np.intp).reshape(-1, 2).T
        whole = run.panoptic.instance_names.parts(run.names)
        return cls(NameParts(whole.said[rows], whole.alike[rows], whole.fit[rows]), right)

    def outcome(self, weights: NameWeights) -> tuple[Float64Array, Float64Array, BoolArray]:
        """The logarithm of the probability of the right name, the probability of the one given, and whether that is
        right, (K,) each."""
        logs = self.parts.log_probabilities(weights)
        return logs[np.arange(len(logs)), self.right], np.exp(logs.max(axis=1)), logs.argmax(axis=1) == self.right


def measure_naming(runs: Sequence[MatchedRun]) -> dict[str, dict[str, Any]]:
    """Figures of each rule over the things of all runs, and, where embeddings were simulated, what the rule that is
    used has with embeddings free of noise; raises BadInput."""
    things = [NamedThings.of(run) for run in runs]
    if not sum(len(each.right) for each in things):
        raise BadInput("no instance of these runs stands for a true one with a name: give others")
    rows = {name: _row(things, weights or fitted(things)) for name, weights in RULES.items()}
    exact = [run.with_exemplars() for run in runs]
    if None not in exact:
        rows["with embeddings free of noise"] = _row([NamedThings.of(run) for run in exact if run], NameWeights())
    return rows


def fitted(things: Sequence[NamedThings]) -> NameWeights:
    """The weights under which the right names are the most probable (maximum likelihood)."""

    def loss(logarithms: Float64Array) -> float:
        weights = NameWeights(*np.exp(logarithms))
        return -float(np.concatenate([each.outcome(weights)[0] for each in things]).mean())

    start = np.log([getattr(NameWeights(), field.name) for field in fields(NameWeights)])
    options = {"initial_simplex": np.concatenate([start[None], start + 0.5 * np.eye(len(start))]), "xatol": 0.01}
    return NameWeights(*np.exp(minimize(loss, start, method="Nelder-Mead", options=options).x))


def naming_table(rows: Mapping[str, Mapping[str, Any]]) -> Table:
    """A line for each rule."""
    n = next(iter(rows.values()))["n"]
    table = Table(title=f"names of {n} things, out of those of their truth", title_justify="left")
    table.add_column("rule")
    for head in ("right, %", "mean log loss", "calibration error", "said", "alike", "embeddings"):
        table.add_column(head, justify="right")
    for name, row in rows.items():
        weights = (f"{weight:.2f}" for weight in row["weights"].values())
        table.add_row(name, f"{100 * row['accuracy']:.1f}", f"{row['log_loss']:.3f}", f"{row['ece']:.3f}", *weights)
    return table


def _row(things: Sequence[NamedThings], weights: NameWeights) -> dict[str, Any]:
    logs, probability, is_right = (
        np.concatenate(part) for part in zip(*(t.outcome(weights) for t in things), strict=True)
    )
    table = calibration(np.minimum(probability, 1.0), is_right)
    assert table is not None
    return {
        "n": len(is_right),
        "accuracy": float(is_right.mean()),
        "log_loss": -float(logs.mean()),
        "ece": table["ece"],
        "weights": asdict(weights),
    }
