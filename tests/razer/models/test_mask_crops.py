"""Square pictures of masks."""

from __future__ import annotations

import numpy as np
import pytest

from razer.models.mask_crops import mask_crops

FILL = np.array([10, 20, 30], np.uint8)


def picture(height=40, width=60):
    return np.random.default_rng(0).integers(0, 256, (height, width, 3), dtype=np.uint8)


def box(rows, columns, shape=(40, 60)):
    mask = np.zeros(shape, bool)
    mask[rows, columns] = True
    return mask


def crop(rgb, mask, size, scale=1.0, background=0.0):
    return mask_crops(rgb, mask[None], size, scale=scale, background=background, fill=FILL)[0]


def test_a_square_mask_is_cut_out_pixel_by_pixel():
    rgb = picture()
    np.testing.assert_array_equal(crop(rgb, box(slice(5, 21), slice(30, 46)), 16), rgb[5:21, 30:46])


def test_pixels_outside_the_mask_do_not_count_without_background():
    rgb, mask = picture(), box(slice(5, 25), slice(10, 24))
    changed = np.where(mask[..., None], rgb, 255 - rgb)
    np.testing.assert_array_equal(crop(rgb, mask, 13, scale=1.5), crop(changed, mask, 13, scale=1.5))
    different = [crop(image, mask, 13, 1.5, 0.3).astype(int) for image in (rgb, changed)]
    assert np.abs(np.subtract(*different)).max() > 10


@pytest.mark.parametrize("background", [0.0, 0.25, 1.0])
def test_background_shows_with_its_share(background):
    rgb, mask = picture(), box(slice(10, 30), slice(20, 30))
    result = crop(rgb, mask, 20, background=background)
    around = background * rgb[10:30, 15:35].astype(float) + (1 - background) * FILL
    expected = np.where(mask[10:30, 15:35, None], rgb[10:30, 15:35], around)
    np.testing.assert_allclose(result, expected, atol=0.51)


def test_what_lies_beyond_the_image_is_filled():
    rgb, mask = picture(), box(slice(0, 10), slice(0, 10))
    result = crop(rgb, mask, 20, scale=2, background=1.0)
    np.testing.assert_allclose(result[:5], np.broadcast_to(FILL, (5, 20, 3)))
    np.testing.assert_allclose(result[:, :5], np.broadcast_to(FILL, (20, 5, 3)))
    np.testing.assert_array_equal(result[5:, 5:], rgb[:15, :15])


def test_larger_things_are_averaged_not_sampled():
    rgb = np.zeros((40, 60, 3), np.uint8)
    rgb[:, ::2] = 200
    result = crop(rgb, box(slice(0, 40), slice(0, 40)), 10)
    np.testing.assert_allclose(result, 100)


def test_a_mask_without_pixels_shows_the_whole_image():
    rgb = picture()
    np.testing.assert_array_equal(crop(rgb, box(slice(0, 0), slice(0, 0)), 16), crop(rgb, np.ones((40, 60), bool), 16))
