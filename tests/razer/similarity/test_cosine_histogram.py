"""Trimmed quantiles of cosines against sorting them."""

from __future__ import annotations

import numpy as np
import pytest

from razer.similarity.cosine_histogram import CosineHistogram


def histogram_of(*parts: np.ndarray) -> CosineHistogram:
    histogram = CosineHistogram()
    for part in parts:
        histogram.add(part)
    return histogram


def test_an_empty_histogram_knows_nothing() -> None:
    histogram = histogram_of(np.zeros(0))
    assert len(histogram) == 0
    assert histogram.below_strangers() == histogram.above_strangers() == (0, 0)
    assert histogram.share_above(-1) == 0


def test_single_values_come_back_as_they_are() -> None:
    for cosine in (-1.0, -0.25, 0.0, 0.5, 0.999, 1.0):
        histogram = histogram_of(np.full(7, cosine))
        assert histogram.below_strangers() == pytest.approx((cosine, 0))
        assert histogram.above_strangers() == pytest.approx((cosine, 0))


def test_what_lies_above_a_cosine_does_not_count_the_cosine_itself() -> None:
    histogram = histogram_of(np.array([0.2, 0.5, 0.5, 0.8, 1.00001]))  # rounding may put a cosine beyond 1
    assert len(histogram) == 5
    assert histogram.share_above(0.5) == pytest.approx(0.4)
    assert histogram.share_above(0.4999) == pytest.approx(0.8)
    assert histogram.share_above(1.0) == 0


def test_centre_and_spread_of_a_population_beside_a_third_of_strangers() -> None:
    rng = np.random.default_rng(0)
    own, above, below = rng.normal(0.5, 0.05, 8000), rng.normal(0.95, 0.01, 4000), rng.normal(0.05, 0.05, 4000)
    assert histogram_of(own, above).below_strangers() == pytest.approx((0.5, 0.05), abs=0.003)
    assert histogram_of(own, below).above_strangers() == pytest.approx((0.5, 0.05), abs=0.003)
    alone = histogram_of(own)
    assert alone.below_strangers() == pytest.approx((0.5, 0.05), abs=0.025)
    assert alone.above_strangers() == pytest.approx((0.5, 0.05), abs=0.025)


def test_the_spread_of_what_agrees_is_that_of_its_wider_side() -> None:
    rng = np.random.default_rng(1)
    skewed = 0.98 - rng.exponential(0.1, 9000)
    centre, spread = histogram_of(skewed).above_strangers()
    low, middle, high = np.quantile(skewed, [1 / 3 + 2 / 3 * 0.1587, 2 / 3, 1 - 2 / 3 * 0.1587])
    assert centre == pytest.approx(middle, abs=0.002)
    assert spread == pytest.approx(max(middle - low, high - middle), abs=0.002)
    assert spread > high - middle + 0.01


def test_the_order_and_grouping_of_cosines_changes_nothing() -> None:
    cosines = np.random.default_rng(2).uniform(-1, 1, 500)
    one, other = histogram_of(cosines), histogram_of(*np.array_split(cosines[::-1], 7))
    assert one.below_strangers() == other.below_strangers()
    assert one.above_strangers() == other.above_strangers()
