"""Means of a feature map over masks, against a walk over every pixel."""

from __future__ import annotations

import numpy as np
import pytest

from razer.models.mask_pooling import coverage, pool_masks


def walked(features, mask):
    """Mean over the mask's pixels, each shared among the cells that it lies in."""
    (rows, columns, _), (height, width) = features.shape, mask.shape
    total, weight = np.zeros(features.shape[2]), 0.0
    for v, u in np.argwhere(mask):
        for row in range(rows):
            tall = min((v + 1) / height, (row + 1) / rows) - max(v / height, row / rows)
            for column in range(columns):
                wide = min((u + 1) / width, (column + 1) / columns) - max(u / width, column / columns)
                if tall > 1e-12 and wide > 1e-12:
                    total += tall * wide * features[row, column]
                    weight += tall * wide
    return total / weight


@pytest.mark.parametrize(
    ("grid", "image"), [((3, 4), (12, 16)), ((4, 5), (10, 13)), ((2, 3), (7, 7)), ((6, 8), (6, 8))]
)
def test_pooling_is_the_mean_over_pixels(grid, image):
    rng = np.random.default_rng(0)
    features = rng.normal(size=(*grid, 5)).astype(np.float32)
    masks = np.stack([rng.random(image) < share for share in (0.1, 0.5, 0.9)])
    expected = [walked(features, mask) for mask in masks]
    np.testing.assert_allclose(pool_masks(features, masks), expected, atol=1e-5)


def test_a_single_pixel_has_the_features_of_its_cell():
    features = np.arange(12, dtype=np.float32).reshape(3, 4, 1)
    mask = np.zeros((1, 30, 40), bool)
    mask[0, 25, 11] = True
    np.testing.assert_allclose(pool_masks(features, mask), [[features[2, 1, 0]]])


def test_coverage_of_whole_and_half_cells():
    mask = np.zeros((1, 4, 8), bool)
    mask[0, :, :6] = True
    np.testing.assert_allclose(coverage(mask, 2, 2), [[[1, 0.5], [1, 0.5]]])


def test_a_mask_without_pixels_counts_as_the_whole_image():
    features = np.random.default_rng(1).normal(size=(3, 4, 2)).astype(np.float32)
    empty, full = np.zeros((1, 12, 16), bool), np.ones((1, 12, 16), bool)
    np.testing.assert_allclose(pool_masks(features, empty), pool_masks(features, full), atol=1e-6)
    np.testing.assert_allclose(pool_masks(features, full)[0], features.mean(axis=(0, 1)), atol=1e-6)


def test_no_masks():
    assert pool_masks(np.ones((3, 4, 2), np.float32), np.zeros((0, 12, 16), bool)).shape == (0, 2)
