"""Sums of noisy observations tell what they are of."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from razer.config import BankSettings
from razer.similarity.similarity_scale import MAX_LOG_ODDS, CalibratedScale, CosinePopulation, SimilarityScale
from razer.tracking.embedding_bank import EmbeddingBank
from razer.tracking.embedding_clusters import SAME_THING_UNITS, EmbeddingClusters

DIMENSION = 512
COSINES = SimilarityScale().calibrated  # units are cosines


def noisy_scale(unlike):
    """Of views at a cosine of 0.7 to what they are of, where unlike things are at `unlike` beneath that noise."""
    return CalibratedScale(CosinePopulation(0.49 * unlike, 0.04, 0.05), CosinePopulation(0.49, 0.04, 0.05))


def learnt_scale(unlike, same):
    scale = SimilarityScale()
    scale.observe(np.full(2000, unlike), np.full(2000, same))
    return scale


def direction(rng):
    vector = rng.standard_normal(DIMENSION)
    return vector / np.linalg.norm(vector)


def turned(vector, cosine, rng):
    """A unit vector at a given cosine."""
    aside = rng.standard_normal(len(vector))
    aside -= (aside @ vector) * vector
    return cosine * vector + np.sqrt(1 - cosine**2) * aside / np.linalg.norm(aside)


def cluster_of(vectors, weights):
    clusters = EmbeddingClusters.of(vectors[0], weights[0])
    for vector, weight in zip(vectors[1:], weights[1:], strict=True):
        clusters = clusters.merged(0, EmbeddingClusters.of(vector, weight))
    return clusters


def test_coherence_is_the_mean_cosine_of_pairs():
    rng = np.random.default_rng(0)
    centre = direction(rng)
    vectors, weights = [turned(centre, 0.8, rng) for _ in range(7)], rng.uniform(0.2, 1, 7)
    pairs = [(i, j) for i in range(7) for j in range(7) if i != j]
    expected = sum(weights[i] * weights[j] * (vectors[i] @ vectors[j]) for i, j in pairs)
    expected /= sum(weights[i] * weights[j] for i, j in pairs)
    assert cluster_of(vectors, weights).coherence(0.3)[0] == pytest.approx(expected)


def test_mean_cosine_is_that_of_all_pairs():
    rng = np.random.default_rng(1)
    vectors = [direction(rng) for _ in range(5)]
    other, weights = direction(rng), rng.uniform(0.2, 1, 5)
    expected = sum(w * (v @ other) for v, w in zip(vectors, weights, strict=True)) / weights.sum()
    assert cluster_of(vectors, weights).mean_cosines(EmbeddingClusters.of(other, 0.3))[0, 0] == pytest.approx(expected)


def test_a_single_observation_is_taken_to_agree_with_others_as_views_of_one_thing_do():
    single = EmbeddingClusters.of(direction(np.random.default_rng(2)), 0.4)
    assert single.coherence(0.49) == pytest.approx(0.49)
    assert single.coherence(1.0) == 1


@pytest.mark.parametrize(("cosine", "n_left"), [(1.0, 1), (0.8, 2)])
def test_slots_of_one_thing_are_told_from_those_of_its_neighbour_under_heavy_noise(cosine, n_left):
    """Observations are at a cosine of 0.5 to each other, yet 1.0 and 0.8 between what they are of differ."""
    scale = noisy_scale(unlike=0.6)
    assert scale.units(0.49 * 0.8) < SAME_THING_UNITS < scale.units(0.49)
    for seed in range(20):
        rng = np.random.default_rng(seed)
        one = direction(rng)
        other = one if cosine == 1 else turned(one, cosine, rng)
        both = [cluster_of([turned(v, 0.7, rng) for _ in range(12)], [0.5] * 12) for v in (one, other)]
        merged = both[0].joined(both[1]).distinct(scale)
        assert len(merged) == n_left
        assert merged.masses.sum() == pytest.approx(12)


def test_taking_together_keeps_the_sum_and_puts_the_largest_first():
    rng = np.random.default_rng(3)
    vectors = [direction(rng) for _ in range(3)]
    clusters = (
        EmbeddingClusters.of(vectors[0], 0.2)
        .joined(EmbeddingClusters.of(vectors[1], 0.5))
        .joined(EmbeddingClusters.of(vectors[2], 0.3))
    )
    left = clusters.distinct(COSINES)
    assert_allclose(left.masses, [0.5, 0.3, 0.2])
    assert_allclose(left.sums.sum(axis=0), clusters.sums.sum(axis=0))


def test_a_bank_of_noisy_observations_of_one_thing_is_its_running_mean():
    rng = np.random.default_rng(4)
    centre = direction(rng)
    observations = [turned(centre, 0.7, rng).astype(np.float32) for _ in range(20)]
    bank = EmbeddingBank(BankSettings(), DIMENSION)
    for each in observations:
        bank.add(each, 0.5)
    mean = np.sum(observations, axis=0)
    assert len(bank.embeddings) == 1
    assert_allclose(bank.embeddings[0], mean / np.linalg.norm(mean), atol=1e-5)


def test_the_order_of_two_banks_does_not_matter_to_what_both_hold():
    rng = np.random.default_rng(5)
    centre, scale = direction(rng), learnt_scale(0.0, 0.49)
    banks = []
    for _ in range(2):
        bank = EmbeddingBank(BankSettings(), DIMENSION, scale)
        for _ in range(10):
            bank.add(turned(centre, 0.7, rng).astype(np.float32), 0.5)
        banks.append(bank)
    masses = [bank.mass for bank in banks]
    banks[0].absorb(banks[1])
    assert banks[0].mass == pytest.approx(sum(masses))
    assert len(banks[0].embeddings) == 1
    assert banks[0].embeddings[0] @ centre > 0.95


def test_few_noisy_observations_are_read_as_their_mean():
    rng = np.random.default_rng(6)
    centre = direction(rng)
    observations = [turned(centre, 0.7, rng).astype(np.float32) for _ in range(3)]
    bank = EmbeddingBank(BankSettings(), DIMENSION)
    for each in observations:
        bank.add(each, 0.5)
    assert len(bank.embeddings) == 3  # they may be of different things
    (mean,), weights = bank.settled()
    assert mean @ centre > 0.82
    assert_allclose(mean, np.sum(observations, axis=0) / np.linalg.norm(np.sum(observations, axis=0)), atol=1e-6)
    assert_allclose(weights, [1])


def test_a_second_appearance_that_was_seen_more_than_once_stays():
    rng = np.random.default_rng(7)
    front, back = direction(rng), direction(rng)
    both = cluster_of([turned(front, 0.9, rng) for _ in range(3)], [0.5] * 3)
    both = both.joined(cluster_of([turned(back, 0.9, rng) for _ in range(2)], [0.5] * 2))
    left = both.joined(EmbeddingClusters.of(turned(back, 0.9, rng), 0.4)).settled(COSINES)
    assert_allclose(left.masses, [1.5, 1.4])


def test_an_empty_bank_settles_to_nothing():
    embeddings, weights = EmbeddingBank(BankSettings(), 4).settled()
    assert embeddings.shape == (0, 4)
    assert len(weights) == 0


def test_noisy_views_of_one_thing_fill_one_cluster_once_the_scale_knows_their_noise():
    rng = np.random.default_rng(8)
    centre, other = direction(rng), direction(rng)
    bank = EmbeddingBank(BankSettings(), DIMENSION, learnt_scale(0.0, 0.49))
    for _ in range(3):
        bank.add(turned(centre, 0.7, rng).astype(np.float32), 0.5)
    assert len(bank.embeddings) == 1  # pairwise cosines of 0.49
    bank.add(turned(other, 0.7, rng).astype(np.float32), 0.5)
    assert len(bank.embeddings) == 2


def test_similarity_of_a_view_does_not_grow_with_the_number_of_views_behind_a_hypothesis():
    rng = np.random.default_rng(9)
    centre = direction(rng)
    view, bank = turned(centre, 0.7, rng), EmbeddingBank(BankSettings(), DIMENSION, learnt_scale(0.0, 0.49))
    similarities = []
    for _ in range(30):
        bank.add(turned(centre, 0.7, rng).astype(np.float32), 0.5)
        similarities.append(bank.similarity(view))
    assert_allclose(similarities, 1, atol=0.25)
    assert similarities[-1] == pytest.approx(1, abs=0.05)
    assert bank.log_odds_same(bank) == pytest.approx(MAX_LOG_ODDS, abs=0.2)


def test_evidence_of_two_banks_is_that_of_their_hypotheses_by_confidence():
    """By hand: four pairs of hypotheses at 0.75, 0.25 and 0.4, 0.6."""
    scale = learnt_scale(0.2, 0.8)
    one, other = (EmbeddingBank(BankSettings(), 3, scale) for _ in range(2))
    assert one.log_odds_same(other) == 0
    one.add(np.array([1, 0, 0], np.float32), 0.75)
    assert one.log_odds_same(other) == 0
    one.add(np.array([0, 1, 0], np.float32), 0.25)
    other.add(np.array([0, 0, 1], np.float32), 0.4)
    assert one.log_odds_same(other) == pytest.approx(scale.log_odds(scale.units(0.0)))
    other.add(np.array([0, 1, 0], np.float32), 0.6)
    unlike, alike = (float(np.exp(scale.log_odds(scale.units(cosine)))) for cosine in (0.0, 1.0))
    assert unlike < 0.2 < 5 < alike
    expected = np.log(0.25 * 0.6 * alike + (1 - 0.25 * 0.6) * unlike)
    assert one.log_odds_same(other) == pytest.approx(expected)
    assert other.log_odds_same(one) == pytest.approx(expected)


def test_one_wrong_vector_among_many_makes_nothing_one():
    """A mask that joined the door with its floor carried the door's vector to the floor."""
    scale = learnt_scale(0.2, 0.8)
    floor, door = (EmbeddingBank(BankSettings(), 3, scale) for _ in range(2))
    for view in range(20):
        floor.add(np.eye(3, dtype=np.float32)[1 if view == 1 else 0], 0.8)
    door.add(np.array([0, 1, 0], np.float32), 0.5)
    assert floor.similarity(np.array([0, 1, 0], np.float32)) > 1
    assert floor.log_odds_same(door) < -0.5


@pytest.fixture(scope="module")
def pictures(real_data):
    """CLIP vectors of pictures of unlike things (40, D), and the scale that a map of such things learns from views at a
    cosine of 0.98 to them."""
    with np.load(real_data / "clip-vit-b32" / "lvis.npz") as table:
        image = table["image"].astype(np.float64)
    image /= np.linalg.norm(image, axis=1, keepdims=True)
    rng = np.random.default_rng(10)
    things = image[rng.choice(len(image), 40, replace=False)]
    scale = SimilarityScale(0.5)
    views = np.array([[turned(thing, 0.98, rng) for thing in things] for _ in range(2)])
    scale.observe((views[0] @ views[0].T)[np.triu_indices(40, 1)], (views[0] * views[1]).sum(axis=1))
    return things, scale


def test_pictures_of_unlike_things_stay_two_hypotheses(pictures):
    """Pairs at a cosine of 0.8 and more, as many household things are: views of both are beyond 0.75."""
    things, scale = pictures
    rng = np.random.default_rng(11)
    cosines = things @ things.T
    pairs = np.argwhere(np.triu((cosines > 0.8) & (cosines < 0.86), 1))
    assert len(pairs) >= 20
    for one, other in things[pairs]:
        bank = EmbeddingBank(BankSettings(), DIMENSION, scale)
        for thing in (one, one, other, one, other):
            bank.add(turned(thing, 0.98, rng).astype(np.float32), 0.3)
        assert len(bank.embeddings) == 2


def test_a_picture_of_something_else_is_an_outlier_to_a_well_seen_track(pictures):
    """No two such pictures have a cosine below 0.2."""
    things, scale = pictures
    rng = np.random.default_rng(12)
    outliers = own_outliers = 0
    for one, other in zip(things[:20], things[20:], strict=True):
        bank = EmbeddingBank(BankSettings(), DIMENSION, scale)
        for _ in range(8):
            bank.add(turned(one, 0.98, rng).astype(np.float32), 0.5)
        own_outliers += bank.outliers
        bank.add(turned(other, 0.98, rng).astype(np.float32), 0.5)
        outliers += bank.outliers
    assert (things @ things.T).min() > BankSettings().outlier
    assert own_outliers == 0
    assert outliers >= 10
