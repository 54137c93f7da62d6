"""Corners: where they lie, and on which surfaces there are any."""

from __future__ import annotations

import numpy as np
import pytest

from razer.errors import UnusableFrame
from razer.frame import Frame, Intrinsics
from slam.config import ColorSettings, SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import (
    ALL_AT_ONCE,
    FeatureExtractor,
    Features,
    Readout,
    faint_texture,
    in_image,
    match_features,
)

CAMERA = Intrinsics(320, 240, 260.0, 260.0, 159.5, 119.5)


def test_an_image_without_corners_has_no_features():
    camera = Intrinsics(64, 48, 50.0, 50.0, 31.5, 23.5)
    black = Frame(0, 0.0, np.zeros((48, 64, 3), np.uint8), np.ones((48, 64), np.float32), camera)
    config = SlamConfig()
    features = FeatureExtractor(config).extract(black, ColorCalibration.nominal())
    assert len(features) == 0
    assert len(match_features(features, features, config.features)) == 0


def test_corners_of_all_octaves_lie_where_they_are():
    # A disk whose rim is full of corners, all about the same centre; OpenCV's own positions are off by 1.5 pixels.
    import cv2

    rng = np.random.default_rng(0)
    off = {octave: [] for octave in range(6)}
    detector = cv2.ORB.create(nfeatures=3000, fastThreshold=8, scaleFactor=1.2)
    for _ in range(60):
        center = 100 + rng.uniform(-0.5, 0.5, 2)
        rows, columns = (np.mgrid[0:800, 0:800] + 0.5) / 4 - 0.5
        disk = np.hypot(columns - center[0], rows - center[1]) < rng.uniform(5, 12)
        image = np.where(disk, 220.0, 40.0).reshape(200, 4, 200, 4).mean((1, 3)).astype(np.uint8)
        corners = [corner for corner in detector.detect(image) if corner.octave in off]
        octaves = np.array([corner.octave for corner in corners])
        points = in_image(np.array([corner.pt for corner in corners]), octaves, image.shape)
        for octave, point in zip(octaves, points, strict=True):
            off[octave].append(point - center)
    for octave, errors in off.items():
        assert np.abs(np.mean(errors, axis=0)).max() < 0.35, octave


def test_a_painted_wall_has_corners_too():
    rng = np.random.default_rng(1)
    grain = rng.normal(0, 1, (60, 80))
    wall = 150 + 3 * np.kron(grain, np.ones((4, 4))) + np.linspace(0, 40, 320)
    image = np.repeat(wall.clip(0, 255).astype(np.uint8)[:, :, None], 3, axis=2)
    frame = Frame(0, 0.0, image, np.full((240, 320), 2.0, np.float32), CAMERA)
    assert len(FeatureExtractor(SlamConfig()).extract(frame, ColorCalibration.nominal())) > 300
    # A gradient is shading, not texture.
    shaded = np.tile(np.linspace(50, 200, 320), (240, 1)).astype(np.uint8)
    assert np.abs(faint_texture(shaded)[20:-20, 20:-20].astype(int) - 128).max() <= 8


@pytest.mark.parametrize("rolling", [True, False])
def test_rows_are_read_one_after_the_other_or_all_at_once(rolling):
    camera = Intrinsics(320, 240, 260.0, 270.0, 150.0, 100.0)
    rows = np.array([-0.5, 119.5, 239.5, 59.5])  # the first one's upper edge, the middle, the last one's lower edge
    rays = np.stack([np.ones(4), (rows - camera.cy) / camera.fy], axis=1)
    readout = Readout.of(camera, ColorSettings(rolling_shutter=rolling))
    features = Features.of(rays, np.zeros((4, 32), np.uint8), np.ones(4), np.ones(4), readout)
    expected = [-0.5, 0.0, 0.5, -0.25] if rolling else np.zeros(4)
    np.testing.assert_allclose(features.row_times, expected, atol=1e-6)
    np.testing.assert_array_equal(features.select(np.array([3, 0])).row_times, features.row_times[[3, 0]])
    assert (readout == ALL_AT_ONCE) == (not rolling)


@pytest.mark.parametrize("side", [1, 2, 3])
def test_images_of_a_few_pixels_cannot_be_used(side):
    camera = Intrinsics(side, side, 1.0, 1.0, 0.0, 0.0)
    frame = Frame(0, 0.0, np.zeros((side, side, 3), np.uint8), np.ones((side, side), np.float32), camera)
    with pytest.raises(UnusableFrame, match=f"an image of {side}x{side} pixels shows nothing"):
        FeatureExtractor(SlamConfig()).extract(frame, ColorCalibration.nominal())
