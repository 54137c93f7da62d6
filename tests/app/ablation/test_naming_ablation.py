"""Weights of naming are found again where votes and embeddings were made by known ones."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from app.ablation import naming_ablation
from app.ablation.naming_ablation import NamedThings, fitted, measure_naming
from razer.query.name_probability import NameParts, NameWeights
from tests.support.cli import call

N_THINGS, N_NAMES = 3000, 12


@pytest.fixture(scope="module")
def things():
    """Things whose right names are drawn by the probabilities that these weights give."""
    rng = np.random.default_rng(0)
    parts = NameParts(*(rng.exponential(1, (N_THINGS, N_NAMES)) for _ in range(3)))
    probabilities = np.exp(parts.log_probabilities(NameWeights(0.5, 1.0, 2.0)))
    right = (probabilities.cumsum(axis=1) > rng.random((N_THINGS, 1))).argmax(axis=1)
    return NamedThings(parts, right)


def test_the_weights_that_made_the_names_are_found(things):
    found = fitted([things])
    assert (found.said, found.alike, found.vectors) == pytest.approx((0.5, 1.0, 2.0), rel=0.15)


def test_fitted_weights_are_calibrated_and_others_are_not(things, monkeypatch):
    monkeypatch.setattr(NamedThings, "of", classmethod(lambda cls, run: things))
    rows = measure_naming([SimpleNamespace(with_exemplars=lambda: None)])
    assert "with embeddings free of noise" not in rows  # these were not simulated
    assert rows["fitted"]["ece"] < 0.03 < rows["as is"]["ece"]
    assert rows["fitted"]["log_loss"] == min(row["log_loss"] for row in rows.values())
    assert {row["n"] for row in rows.values()} == {N_THINGS}
    assert naming_ablation.naming_table(rows).row_count == len(rows)


def test_what_is_no_run_is_refused(tmp_path, capsys):
    assert call("ablate", "--naming", tmp_path) == 2
    assert "no run folder" in capsys.readouterr().err
