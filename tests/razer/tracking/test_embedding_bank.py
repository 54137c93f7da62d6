"""The embedding bank's rules (docs/method.md step 8), one by one, and what always holds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose

from razer.config import BankSettings
from razer.similarity.similarity_scale import SimilarityScale
from razer.tracking.embedding_bank import EmbeddingBank, bank_similarity, euclidean_distance, same_thing_doubt
from tests.support.scenes import unit

SETTINGS = BankSettings(hypotheses=3, similarity=0.75, outlier=0.2)


def at_angle(degrees: float) -> np.ndarray:
    """A unit vector in the plane of the first two of four axes."""
    return unit(np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0, 0)


def bank_of(*observations: tuple[np.ndarray, float], settings: BankSettings = SETTINGS) -> EmbeddingBank:
    bank = EmbeddingBank(settings, len(observations[0][0]) if observations else 4)
    for embedding, confidence in observations:
        bank.add(embedding, confidence)
    return bank


def test_an_empty_bank_knows_nothing() -> None:
    bank = bank_of()
    assert bank.embeddings.shape == (0, 4)
    assert len(bank.confidences) == bank.mass == 0
    assert bank.similarity(at_angle(0)) == 0


def test_a_similar_observation_joins_by_its_weight() -> None:
    bank = bank_of((at_angle(0), 0.3), (at_angle(40), 0.6))  # cos 40 = 0.77
    expected = 0.3 * at_angle(0).astype(float) + 0.6 * at_angle(40)
    assert_allclose(bank.embeddings, [expected / np.linalg.norm(expected)], atol=1e-6)
    assert_allclose(bank.confidences, [1.0])
    assert bank.mass == pytest.approx(0.9)


def test_an_observation_joins_the_nearest_of_several() -> None:
    bank = bank_of((at_angle(0), 0.9), (at_angle(60), 0.5), (at_angle(35), 0.2))
    assert len(bank.embeddings) == 2
    assert_allclose(bank.confidences, [0.9 / 1.6, 0.7 / 1.6])
    assert bank.embeddings[1] @ at_angle(35) > np.cos(np.radians(25))
    assert_allclose(bank.embeddings[0], at_angle(0), atol=1e-6)


def test_a_different_observation_opens_a_slot() -> None:
    bank = bank_of((at_angle(0), 0.3), (at_angle(45), 0.6))  # cos 45 = 0.71
    assert_allclose(bank.embeddings, [at_angle(45), at_angle(0)], atol=1e-6)  # the strongest first
    assert_allclose(bank.confidences, [2 / 3, 1 / 3])


FULL = ((at_angle(0), 0.5), (at_angle(50), 0.2), (at_angle(100), 0.3))


def test_a_stronger_newcomer_replaces_the_weakest_of_a_full_bank() -> None:
    bank = bank_of(*FULL, (at_angle(150), 0.25))
    assert_allclose(bank.embeddings, [at_angle(0), at_angle(100), at_angle(150)], atol=1e-6)
    assert_allclose(bank.confidences, np.array([0.5, 0.3, 0.25]) / 1.05)


def test_a_weaker_newcomer_merges_into_the_nearest_of_a_full_bank() -> None:
    bank = bank_of(*FULL, (at_angle(150), 0.1))
    expected = 0.3 * at_angle(100).astype(float) + 0.1 * at_angle(150)
    assert len(bank.embeddings) == 3
    assert_allclose(bank.embeddings[1], expected / np.linalg.norm(expected), atol=1e-6)
    assert_allclose(bank.confidences, np.array([0.5, 0.4, 0.2]) / 1.1)


def test_strangers_to_a_well_seen_track_are_counted_and_not_fused() -> None:
    bank = bank_of(*[(at_angle(0), 0.5)] * 6)
    bank.add(at_angle(90), 1.0)
    bank.add(at_angle(180), 1.0)
    assert bank.outliers == 2
    assert_allclose(bank.embeddings, [at_angle(0)], atol=1e-6)
    assert bank.mass == pytest.approx(3.0)
    bank.add(at_angle(70), 0.4)  # cos 70 = 0.34: different, but no stranger
    assert bank.outliers == 2
    assert len(bank.embeddings) == 2


def test_a_track_seen_once_knows_no_strangers() -> None:
    bank = bank_of((at_angle(0), 0.5), (at_angle(180), 0.4))
    assert bank.outliers == 0
    assert len(bank.embeddings) == 2


VECTORS = arrays(np.float64, (7, 5), elements=st.floats(-1, 1, width=32)).filter(
    lambda rows: bool((np.linalg.norm(rows, axis=1) > 0.1).all())
)
CONFIDENCES = st.lists(st.floats(0.01, 1), min_size=7, max_size=7)


@given(vectors=VECTORS, confidences=CONFIDENCES)
@settings(deadline=None, max_examples=60)
def test_one_hypothesis_is_the_weighted_running_mean(vectors: np.ndarray, confidences: list[float]) -> None:
    embeddings = [unit(*row) for row in vectors]
    mean = np.sum([e.astype(float) * c for e, c in zip(embeddings, confidences, strict=True)], axis=0)
    bank = bank_of(*zip(embeddings, confidences, strict=True), settings=BankSettings(hypotheses=1))
    assert bank.mass == pytest.approx(sum(confidences))
    assert_allclose(bank.confidences, [1.0])
    if np.linalg.norm(mean) > 1e-3:
        assert_allclose(bank.embeddings[0], mean / np.linalg.norm(mean), atol=1e-4)


@given(vectors=VECTORS, confidences=CONFIDENCES, hypotheses=st.integers(1, 4))
@settings(deadline=None, max_examples=60)
def test_a_bank_is_always_sound(vectors: np.ndarray, confidences: list[float], hypotheses: int) -> None:
    bank = EmbeddingBank(SETTINGS.model_copy(update={"hypotheses": hypotheses}), 5)
    for row, confidence in zip(vectors, confidences, strict=True):
        bank.add(unit(*row), confidence)
        assert 1 <= len(bank.embeddings) <= hypotheses
        assert bank.embeddings.dtype == np.float32
        assert bank.confidences.sum() == pytest.approx(1.0)
        assert (np.diff(bank.confidences) <= 0).all()
        assert bank.mass <= sum(confidences) + 1e-9
        assert -1 - 1e-6 <= bank.similarity(unit(*row)) <= 1 + 1e-6


def test_similarity_is_the_highest_cosine() -> None:
    bank = bank_of(*FULL)
    assert bank.similarity(at_angle(75)) == pytest.approx(np.cos(np.radians(25)))
    assert bank.similarity(at_angle(-60)) == pytest.approx(0.5)


def test_absorbing_a_duplicate_adds_its_mass() -> None:
    one, other = bank_of((at_angle(0), 0.5), (at_angle(60), 0.4)), bank_of((at_angle(10), 0.3), (at_angle(120), 0.2))
    other.outliers = 4
    one.absorb(other)
    assert one.mass == pytest.approx(1.4)
    assert one.outliers == 4
    assert_allclose(one.confidences, np.array([0.8, 0.4, 0.2]) / 1.4)
    merged = 0.5 * at_angle(0).astype(float) + 0.3 * at_angle(10)
    assert_allclose(one.embeddings[0], merged / np.linalg.norm(merged), atol=1e-6)


def test_similarities_of_many_banks_are_those_of_each() -> None:
    rng = np.random.default_rng(0)
    banks = [bank_of(*FULL[:n]) for n in (1, 3, 2)]
    embeddings = np.stack([unit(*row) for row in rng.normal(size=(5, 4))])
    expected = [[bank.similarity(e) for e in embeddings] for bank in banks]
    assert_allclose(bank_similarity(banks, embeddings), expected, atol=1e-6)
    assert bank_similarity([], embeddings).shape == (0, 5)
    assert bank_similarity(banks, np.zeros((0, 4), np.float32)).shape == (3, 0)


def test_the_probability_of_one_thing_by_hand() -> None:
    """A scale that has seen nothing: unlike things are at right angles, and one vector in ten is wrong."""
    bank = EmbeddingBank(SETTINGS, 4, SimilarityScale())
    bank.add(at_angle(0), 0.5)
    assert bank.probability_same(at_angle(0)) == pytest.approx(0.9, abs=1e-4)
    assert bank.probability_same(at_angle(60)) == pytest.approx(0.5, abs=1e-4)
    assert bank.probability_same(at_angle(90)) == pytest.approx(0.1, abs=1e-4)
    doubt = same_thing_doubt([bank], np.stack([at_angle(0), at_angle(60), at_angle(90)]))
    assert doubt[0] == pytest.approx([0.1, 0.5, 0.9], abs=1e-4)


def test_each_bank_is_read_by_its_own_hypotheses() -> None:
    """The first of two banks has the nearer one first, the second has it last."""
    first, second = bank_of((at_angle(0), 0.9), (at_angle(90), 0.1)), bank_of((at_angle(180), 0.9), (at_angle(45), 0.1))
    probes = np.stack([at_angle(0), at_angle(90), at_angle(45)])
    expected = [[max(e @ probe for e in bank.embeddings) for probe in probes] for bank in (first, second)]
    similarity = bank_similarity([first, second], probes)
    raw = [[first.scale.units(float(cosine)) for cosine in row] for row in expected]
    assert_allclose(similarity, raw, atol=1e-6)


def test_euclidean_distance_by_hand() -> None:
    """The mean of two views at right angles has length 0.707 and lies between them."""
    merging = BankSettings(hypotheses=1)
    bank, other = bank_of((at_angle(0), 1.0), (at_angle(90), 1.0), settings=merging), bank_of((at_angle(90), 0.3))
    distance = euclidean_distance([bank, other], np.stack([at_angle(0), at_angle(90)]))
    assert distance == pytest.approx(np.array([[np.sqrt(0.5), np.sqrt(0.5)], [np.sqrt(2), 0.0]]), abs=1e-6)
