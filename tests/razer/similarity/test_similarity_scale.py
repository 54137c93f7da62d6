"""Units of unlike ... same, learnt from populations of all kinds of embedders."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from razer.similarity.similarity_scale import MAX_LOG_ODDS, CalibratedScale, CosinePopulation, SimilarityScale

RNG = np.random.default_rng
AXIS = np.linspace(-1, 2, 61)


def learnt(unlike: np.ndarray, same: np.ndarray, unrelated_cosine: float = 0.0) -> SimilarityScale:
    scale = SimilarityScale(unrelated_cosine)
    scale.observe(unlike, same)
    return scale


def test_without_evidence_the_prior_holds() -> None:
    cosines = np.array([-1, 0, 0.3, 1.0])
    np.testing.assert_allclose(SimilarityScale().units(cosines), cosines)
    assert SimilarityScale(0.8).units(0.8) == pytest.approx(0)
    assert SimilarityScale(0.8).units(0.9) == pytest.approx(0.5)
    assert SimilarityScale(0.8).units(1.0) == pytest.approx(1)


# Mean and spread of unlike things and of views of one thing: the simulator's vectors, CLIP's pictures, names, colours.
KINDS = [(0.0, 0.06, 0.49, 0.05), (0.72, 0.07, 0.9, 0.03), (0.8, 0.03, 1.0, 0.0), (0.4, 0.2, 0.9, 0.08)]


@pytest.mark.parametrize(("unlike", "spread", "same", "same_spread"), KINDS)
@pytest.mark.parametrize("prior", [0.0, 0.5])
def test_means_of_the_populations_become_0_and_1_whatever_the_embedder(
    unlike: float, spread: float, same: float, same_spread: float, prior: float
) -> None:
    rng = RNG(0)
    scale = learnt(rng.normal(unlike, spread, 3000), rng.normal(same, same_spread, 3000).clip(-1, 1), prior)
    tolerance = 0.6 * max(spread, same_spread) / (same - unlike)
    assert scale.units(unlike) == pytest.approx(0, abs=tolerance)
    assert scale.units(same) == pytest.approx(1, abs=tolerance)
    assert scale.units((unlike + same) / 2) == pytest.approx(0.5, abs=tolerance)
    assert scale.log_odds(0.0) < -1.5
    assert scale.log_odds(1.0) > 1.5


def test_the_prior_fades() -> None:
    units = []
    for count in (0, 5, 20, 80, 2000):
        scale = learnt(np.full(count, 0.7), np.full(count, 0.9))
        units.append((scale.units(0.7), scale.units(0.9)))
    unlike, same = np.array(units).T
    assert (np.diff(unlike) < 0).all()
    assert (np.diff(same) > 0).all()
    assert (unlike[0], same[0]) == pytest.approx((0.7, 0.9))
    assert (unlike[-1], same[-1]) == pytest.approx((0, 1), abs=0.03)


def test_twins_among_unlike_things_and_wrong_vectors_among_views_change_little() -> None:
    rng = RNG(1)
    unlike, same = rng.normal(0.1, 0.05, 4000), rng.normal(0.6, 0.05, 4000)
    spoilt = learnt(np.r_[unlike, rng.normal(0.6, 0.05, 1000)], np.r_[same, rng.normal(0.1, 0.05, 1000)])
    clean = learnt(unlike, same)
    np.testing.assert_allclose(spoilt.units(AXIS[20:41]), clean.units(AXIS[20:41]), atol=0.1)
    # ... but a single cosine proves less: a fifth of either kind looks like the other.
    assert spoilt.log_odds(0.0) == pytest.approx(np.log(0.2 / 0.8), abs=0.25)
    assert spoilt.log_odds(1.0) == pytest.approx(-np.log(0.2 / 0.8), abs=0.25)
    assert clean.log_odds(0.0) == pytest.approx(-np.log(9), abs=0.1)  # one in ten is taken for wrong in any case
    assert clean.log_odds(1.0) == pytest.approx(np.log(9), abs=0.1)
    distinct = learnt(np.full(9000, 0.0), np.full(9000, 1.0))
    assert (distinct.log_odds(1.0), distinct.log_odds(0.0)) == pytest.approx((MAX_LOG_ODDS, -MAX_LOG_ODDS))


def test_an_embedder_whose_vectors_are_all_equal_says_nothing() -> None:
    scale = learnt(np.ones(1000), np.ones(1000))
    for cosine in (1.0, 0.999999):
        assert scale.units(cosine) == pytest.approx(1, abs=0.02)  # nothing is forbidden
        assert scale.log_odds(scale.units(cosine)) == pytest.approx(0, abs=0.1)


def test_an_embedder_of_noise_says_nothing() -> None:
    rng = RNG(2)
    scale = learnt(rng.normal(0, 0.1, 20000), rng.normal(0, 0.1, 20000))
    cosines = rng.normal(0, 0.1, 1000)
    odds = scale.log_odds(scale.units(cosines))
    assert np.abs(odds).max() < 1.0  # single cosines of 3 sigma
    assert np.abs(odds).mean() < 0.3
    far = learnt(rng.normal(0.2, 0.1, 9000), rng.normal(0, 0.1, 9000))  # things less like themselves than others
    np.testing.assert_array_equal(far.log_odds(far.units(cosines)), 0)
    np.testing.assert_array_equal(far.units(cosines), 1)


POPULATIONS = st.builds(
    CosinePopulation, mean=st.floats(-0.5, 1), spread=st.floats(0.02, 0.5), strangers=st.floats(0.02, 0.4)
)


@given(unlike=POPULATIONS, same=POPULATIONS)
@settings(deadline=None, max_examples=200)
def test_evidence_grows_with_similarity_and_is_bounded(unlike: CosinePopulation, same: CosinePopulation) -> None:
    scale = CalibratedScale(unlike, same)
    assert (np.diff(scale.units(AXIS)) >= 0).all()
    odds = scale.log_odds(AXIS)
    assert np.isfinite(odds).all()
    assert (np.diff(odds) >= -1e-9).all()
    assert odds[0] >= np.log(same.strangers) - 1e-9
    assert odds[-1] <= -np.log(unlike.strangers) + 1e-9


def test_evidence_is_the_ratio_of_the_two_mixtures_between_their_means() -> None:
    unlike, same = CosinePopulation(0.2, 0.1, 0.1), CosinePopulation(0.7, 0.05, 0.2)

    def density(cosine: float, kind: CosinePopulation) -> float:
        return float(np.exp(-(((cosine - kind.mean) / kind.spread) ** 2) / 2) / kind.spread)

    scale = CalibratedScale(unlike, same)
    for cosine in (0.2, 0.35, 0.5, 0.6, 0.7):
        by_same, by_unlike = density(cosine, same), density(cosine, unlike)
        expected = np.log((0.8 * by_same + 0.2 * by_unlike) / (0.9 * by_unlike + 0.1 * by_same))
        assert scale.log_odds(scale.units(cosine)) == pytest.approx(expected)
    assert scale.log_odds(scale.units(0.95)) == scale.log_odds(1.0)  # beyond a mean says no more
    assert scale.log_odds(scale.units(-0.5)) == scale.log_odds(0.0)


def test_the_order_of_pairs_and_frames_changes_nothing() -> None:
    rng = RNG(3)
    unlike, same = rng.uniform(-1, 1, 300), rng.uniform(0, 1, 100)
    one, other = learnt(unlike, same), SimilarityScale()
    for part, views in zip(np.array_split(unlike[::-1], 9), np.array_split(rng.permutation(same), 9), strict=True):
        other.observe(part, views)
    assert one.calibrated == other.calibrated


def test_pictures_of_unlike_things_are_at_0_though_their_cosines_are_at_072(real_data) -> None:
    rng = RNG(4)
    with np.load(real_data / "clip-vit-b32" / "lvis.npz") as table:
        image = table["image"].astype(np.float64)
    image /= np.linalg.norm(image, axis=1, keepdims=True)
    scale = SimilarityScale()
    for _ in range(30):
        things = image[rng.choice(len(image), 12, replace=False)]
        unlike = (things @ things.T)[np.triu_indices(12, 1)]
        scale.observe(unlike, rng.normal(0.9, 0.03, 10))
    things = image[rng.choice(len(image), 200, replace=False)]
    cosines = (things @ things.T)[np.triu_indices(200, 1)]
    assert cosines.mean() == pytest.approx(0.72, abs=0.02)
    assert np.median(scale.units(cosines)) == pytest.approx(0, abs=0.25)
    assert (scale.log_odds(scale.units(cosines)) < 0).mean() > 0.8
    assert np.mean(scale.units(cosines) > 0.75) < 0.1 < np.mean(cosines > 0.75)
