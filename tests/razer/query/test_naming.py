"""Naming out of a list, against a literal reference, and what it must not depend on."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from razer.query import naming
from razer.query import ranking as rules
from razer.query.embedding_table import EmbeddingTable
from razer.query.naming import NameShares, name_log_shares, ranked_names
from tests.support.named_vectors import unit_rows

DIMENSION = 24


def some_banks(rng, sizes=(1, 3, 2, 1, 2)):
    banks = {}
    for number, size in enumerate(sizes):
        weights = np.sort(rng.uniform(0.1, 1, size))[::-1]
        banks[10 * number + 7] = (unit_rows(rng.standard_normal((size, DIMENSION))), weights / weights.sum())
    return banks


def literal_log_shares(banks, names):
    """One instance, one hypothesis and one name after the other."""
    n = len(banks)
    strongest = np.mean([vectors[0] for vectors, _ in banks.values()], axis=0)
    common = rules.COMMON_SHARE * n / (n + rules.FEW_INSTANCES) * strongest
    rows = []
    for vectors, weights in banks.values():
        best = np.full(len(names), -np.inf)
        for vector, weight in zip(vectors, weights, strict=True):
            logits = [rules.SHARPNESS * float((vector - common) @ name) for name in names]
            total = np.log(sum(np.exp(logit) for logit in logits))
            prior = rules.SHARE_POWER * np.log(weight / weights[0])
            best = np.maximum(best, [logit - total + prior for logit in logits])
        rows.append(best)
    return np.array(rows)


def test_shares_are_those_of_the_literal_reference(monkeypatch):
    rng = np.random.default_rng(0)
    banks, names = some_banks(rng), unit_rows(rng.standard_normal((11, DIMENSION)))
    expected = literal_log_shares(banks, names)
    table = EmbeddingTable.of(banks)
    assert_allclose(name_log_shares(table, names), expected, atol=2e-3)
    assert_array_equal(ranked_names(table, names), np.argsort(-expected, axis=1))
    # Some instances alone, in any order, are named as they are among all; and so in small portions.
    rows = np.array([3, 1, 4])
    monkeypatch.setattr(naming, "_ROWS_AT_ONCE", 2)
    assert_allclose(name_log_shares(table, names, rows), expected[rows], atol=2e-3)


def test_a_weak_hypothesis_that_fits_a_name_exactly_does_not_name_the_instance():
    names = np.eye(3, DIMENSION, dtype=np.float32)
    strong = unit_rows(np.array([[1.0, 0.2, 0.0], [0.0, 0.0, 1.0]]) @ names)
    table = EmbeddingTable.of({4: (strong, np.array([0.8, 0.2])), 9: (names[[1]], np.ones(1))})
    assert ((table.best(table.vectors @ names.T)).argmax(axis=1) == [2, 1]).all()  # by cosine the neighbour's name
    assert ranked_names(table, names)[:, 0].tolist() == [0, 1]


def test_a_single_name_and_no_instances():
    names = np.eye(1, DIMENSION, dtype=np.float32)
    assert ranked_names(EmbeddingTable.of({3: (names, np.ones(1))}), names).tolist() == [[0]]
    assert ranked_names(EmbeddingTable.of({}), names).shape == (0, 1)


def test_the_share_of_a_set_is_what_its_names_have_together(monkeypatch):
    rng = np.random.default_rng(3)
    banks, names = some_banks(rng), unit_rows(rng.standard_normal((11, DIMENSION)) + 0.5)
    table, members = EmbeddingTable.of(banks), np.array([7, 0, 4])
    literal = []
    for vectors, weights in banks.values():
        logits = [rules.SHARPNESS * (v - rules.COMMON_SHARE * rules.common_part(table)) @ names.T for v in vectors]
        sums = [np.exp(x[members] - x.max()).sum() / np.exp(x - x.max()).sum() for x in logits]
        literal.append(max(s * (w / weights[0]) ** rules.SHARE_POWER for s, w in zip(sums, weights, strict=True)))
    monkeypatch.setattr(naming, "_ROWS_AT_ONCE", 2)
    assert_allclose(NameShares(table, names).set_shares(members), literal, rtol=1e-3, atol=1e-6)
    assert_allclose(NameShares(table, names).set_shares(np.arange(11)), 1, rtol=1e-6)
    # Two names between which an instance cannot be told are as sure together as one that it could be told by.
    pair = np.eye(3, DIMENSION, dtype=np.float32)[[0, 0, 1]]
    single = EmbeddingTable.of({5: (pair[[0]], np.ones(1))})
    assert_allclose(np.exp(name_log_shares(single, pair)), [[0.5, 0.5, 0]], atol=1e-6)
    assert_allclose(NameShares(single, pair).set_shares(np.array([0, 1])), [1], atol=1e-6)
    assert NameShares(EmbeddingTable.of({}), names[:, :0]).set_shares(members).shape == (0,)
