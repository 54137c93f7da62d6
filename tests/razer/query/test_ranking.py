"""Ranking against a literal reference, and what it must not depend on."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from razer.mesh.labelled_mesh import LabelledMesh
from razer.panoptic_map import PanopticMap
from razer.query import ranking as rules
from razer.query.embedding_table import EmbeddingTable
from razer.query.ranking import NegativePrompts, TextRanking, image_scores
from razer.query.text_queries import TextQueryEncoder
from razer.semantics.labelling import best_names, label
from razer.vocabulary import Category
from tests.support.named_vectors import unit_rows

DIMENSION, NAMES = 32, 40
# The figures of the method, once more: whoever changes one has measured anew.
SHARPNESS, COMMON_SHARE, FEW_INSTANCES, SHARE_POWER, SAME_NAME = 150.0, 0.4, 10, 8.0, 0.99
SLOPE, EVEN_LOG_RATIO, PRESENT = 0.86, 3.66, 0.6


def some_banks(rng, sizes=(1, 3, 2, 1, 2)):
    banks = {}
    for number, size in enumerate(sizes):
        weights = np.sort(rng.uniform(0.1, 1, size))[::-1]
        banks[10 * number + 7] = (unit_rows(rng.standard_normal((size, DIMENSION))), weights / weights.sum())
    return banks


def some_negatives(rng):
    return NegativePrompts([f"name {i}" for i in range(NAMES)], unit_rows(rng.standard_normal((NAMES, DIMENSION))))


def literal_log_ratios(banks, negatives, query):
    """As the text of `ranking` says, one instance and one hypothesis after the other."""
    n = len(banks)
    strongest = np.mean([vectors[0] for vectors, _ in banks.values()], axis=0)
    common = COMMON_SHARE * n / (n + FEW_INSTANCES) * strongest
    others = [name for name in negatives.vectors if name @ query <= SAME_NAME]
    result = []
    for vectors, weights in banks.values():
        values = []
        for vector, weight in zip(vectors, weights, strict=True):
            rest = np.mean([np.exp(SHARPNESS * ((vector - common) @ name)) for name in others])
            value = SHARPNESS * ((vector - common) @ query) - np.log(rest)
            values.append(value + SHARE_POWER * np.log(weight / weights[0]))
        result.append(max(values))
    return np.array(result)


@pytest.mark.parametrize("rows_at_once", [2, 4096])
def test_evidence_is_that_of_the_literal_reference(monkeypatch, rows_at_once):
    monkeypatch.setattr(rules, "_ROWS_AT_ONCE", rows_at_once)
    rng = np.random.default_rng(0)
    banks, negatives = some_banks(rng), some_negatives(rng)
    queries = np.concatenate([unit_rows(rng.standard_normal((3, DIMENSION))), negatives.vectors[[5]]])
    expected = np.stack([literal_log_ratios(banks, negatives, query) for query in queries], axis=1)
    found = TextRanking(EmbeddingTable.of(banks), negatives).log_ratios(queries)
    assert_allclose(found, expected, atol=2e-3)


def test_a_score_is_the_logistic_of_the_log_ratio():
    rng = np.random.default_rng(7)
    ranking = TextRanking(EmbeddingTable.of(some_banks(rng)), some_negatives(rng))
    queries = unit_rows(rng.standard_normal((6, DIMENSION)))
    expected = 1 / (1 + np.exp(-SLOPE * (ranking.log_ratios(queries) - EVEN_LOG_RATIO)))
    assert_allclose(ranking.scores(queries), expected, rtol=1e-9)
    assert rules.PRESENT == PRESENT


def test_names_of_a_set_do_not_compete_among_themselves():
    rng = np.random.default_rng(11)
    banks, negatives = some_banks(rng), some_negatives(rng)
    ranking = TextRanking(EmbeddingTable.of(banks), negatives)
    names = np.concatenate([negatives.vectors[[4, 30]], unit_rows(rng.standard_normal((1, DIMENSION)))])
    rest = NegativePrompts(NAMES * ["rest"], np.delete(negatives.vectors, [4, 30], axis=0))
    expected = np.max([literal_log_ratios(banks, rest, name) for name in names], axis=0)
    assert_allclose(ranking.set_scores(names), 1 / (1 + np.exp(-SLOPE * (expected - EVEN_LOG_RATIO))), rtol=2e-3)
    for name in names:
        assert_allclose(ranking.set_scores(name[None]), ranking.scores(name[None])[:, 0], rtol=1e-9)


def test_what_nothing_competes_with_is_beyond_doubt_and_finite():
    """Where the query is the only negative prompt, its own share is all but what rounding leaves, and a billionth."""
    rng = np.random.default_rng(8)
    name = unit_rows(rng.standard_normal((1, DIMENSION)))
    ranking = TextRanking(EmbeddingTable.of({1: (name, np.ones(1))}), NegativePrompts(["name"], name))
    assert 10 < ranking.log_ratios(name)[0, 0] < np.log(1.1e9)


def test_a_near_copy_of_a_negative_prompt_does_not_compete_with_it():
    rng = np.random.default_rng(9)
    banks, negatives = some_banks(rng), some_negatives(rng)
    aside = unit_rows(rng.standard_normal((1, DIMENSION)))[0]
    aside = unit_rows((aside - (aside @ negatives.vectors[3]) * negatives.vectors[3])[None])[0]
    for cosine, is_same in ((0.993, True), (0.987, False)):
        query = (cosine * negatives.vectors[3] + np.sqrt(1 - cosine**2) * aside).astype(np.float32)[None]
        others = np.delete(negatives.vectors, 3, axis=0) if is_same else negatives.vectors
        expected = TextRanking(EmbeddingTable.of(banks), NegativePrompts([""] * len(others), others)).log_ratios(query)
        held = TextRanking(EmbeddingTable.of(banks), negatives).log_ratios(query)
        assert_allclose(np.minimum(held, 15), np.minimum(expected, 15), atol=1e-3)


def test_a_name_that_the_contrast_holds_competes_with_the_others_only():
    rng = np.random.default_rng(1)
    banks, negatives = some_banks(rng), some_negatives(rng)
    banks[7] = (negatives.vectors[[3]], np.ones(1))
    without = NegativePrompts(negatives.names, np.delete(negatives.vectors, 3, axis=0))
    query = negatives.vectors[[3]]
    held = TextRanking(EmbeddingTable.of(banks), negatives).log_ratios(query)
    expected = TextRanking(EmbeddingTable.of(banks), without).log_ratios(query)
    # What is beyond doubt is cut off where subtracting a name from all would lose digits.
    assert_allclose(np.minimum(held, 15), np.minimum(expected, 15), atol=1e-3)
    scores = TextRanking(EmbeddingTable.of(banks), negatives).scores(query)[:, 0]
    assert scores.argmax() == 0
    assert scores[0] > PRESENT > scores[1:].max()


def test_many_queries_at_once_are_those_one_by_one_and_instances_do_not_depend_on_their_order():
    rng = np.random.default_rng(2)
    banks, negatives = some_banks(rng), some_negatives(rng)
    queries = unit_rows(rng.standard_normal((4, DIMENSION)))
    ranking = TextRanking(EmbeddingTable.of(banks), negatives)
    one_by_one = np.concatenate([ranking.scores(query[None]) for query in queries], axis=1)
    assert_allclose(ranking.scores(queries), one_by_one, atol=1e-6)
    turned = TextRanking(EmbeddingTable.of(dict(reversed(banks.items()))), negatives)
    assert_allclose(turned.scores(queries)[::-1], one_by_one, atol=1e-5)


def test_a_weak_hypothesis_gives_way_to_an_instance_that_is_mostly_that():
    rng = np.random.default_rng(4)
    negatives = some_negatives(rng)
    chair, table = negatives.vectors[:2]
    banks = {1: (np.stack([table, chair]), np.array([0.65, 0.35])), 2: (chair[None], np.ones(1))}
    scores = TextRanking(EmbeddingTable.of(banks), negatives).log_ratios(chair[None])[:, 0]
    assert scores[1] > scores[0]


def test_an_empty_map_and_instances_without_embeddings():
    rng = np.random.default_rng(5)
    nothing = (np.zeros((0, DIMENSION), np.float32), np.zeros(0))
    assert len(EmbeddingTable.of({3: nothing})) == 0
    banks = {3: nothing, **some_banks(rng)}
    assert 3 not in EmbeddingTable.of(banks).ids
    empty = EmbeddingTable.of({})
    assert len(empty) == 0


class TwoNames:
    """A table of two names."""

    known_names = ("a", "b")

    def embed_texts(self, texts):
        return np.eye(2, DIMENSION, dtype=np.float32)[["ab".index(text) for text in texts]]


def test_in_a_map_without_instances_nothing_is_found():
    nothing = np.zeros((0, 3), np.int32)
    mesh = LabelledMesh(nothing.astype(np.float32), nothing.astype(np.uint8), nothing[:, 0], nothing)
    panoptic = PanopticMap.of([], mesh, TextQueryEncoder(TwoNames()))
    assert panoptic.query("a").hits == panoptic.query_image(np.eye(1, DIMENSION, dtype=np.float32)[0]).hits == ()
    assert label(panoptic, [Category(1, "a", 0, "", False)]) == []
    assert best_names(panoptic, ["a", "b"]) == {}


def test_likeness_of_an_image_by_hand():
    banks = {3: (np.eye(3, dtype=np.float32)[[0, 2]], np.array([0.7, 0.3])), 8: (np.eye(3)[[1]], np.ones(1))}
    hypotheses = EmbeddingTable.of(banks)
    common = np.array([0.5, 0.5, 0.0]) * 2 / 12  # of the strongest of each, of two among ten
    assert_allclose(rules.common_part(hypotheses), common, rtol=1e-6)

    def cosine(a, b):
        return (a - common) @ (b - common) / np.linalg.norm(a - common) / np.linalg.norm(b - common)

    query = np.array([0.0, 0.6, 0.8], np.float32)
    x, y, z = np.eye(3)
    expected = [max(cosine(x, query), cosine(z, query)), cosine(y, query)]
    assert_allclose(image_scores(hypotheses, query), expected, rtol=1e-5)
    assert_allclose(image_scores(hypotheses, -query), np.zeros(2), atol=1e-6)
    # An image of nothing but what all have in common is like none of them.
    assert_allclose(image_scores(hypotheses, common.astype(np.float32)), 0, atol=1e-6)
    alone = EmbeddingTable.of({3: banks[3]})
    assert_allclose(rules.common_part(alone), x / 11, rtol=1e-6)
    nobody = EmbeddingTable(hypotheses.ids[:0], hypotheses.starts[:0], hypotheses.vectors[:0], np.zeros(0))
    assert rules.common_part(nobody).tolist() == [0, 0, 0]


def test_an_image_is_nearest_to_the_instance_it_shows():
    rng = np.random.default_rng(6)
    # All in a narrow cone, as CLIP's image vectors are.
    cone = unit_rows(rng.standard_normal(512)) * 2
    vectors = unit_rows(cone + unit_rows(rng.standard_normal((30, 512))))
    hypotheses = EmbeddingTable.of({i: (v[None], np.ones(1)) for i, v in enumerate(vectors[:20])})
    for row in range(20):
        scores = image_scores(hypotheses, vectors[row])
        assert scores.argmax() == row
        assert scores[row] == pytest.approx(1)
        assert np.delete(scores, row).max() < PRESENT
    for absent in vectors[20:]:
        assert image_scores(hypotheses, absent).max() < PRESENT
