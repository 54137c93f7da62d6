"""Places that look alike: what two views contradict each other in, and when hypotheses suffice to tie two submaps."""

from __future__ import annotations

import numpy as np
import pytest

from razer.frame import Frame, Intrinsics
from slam.backend.free_space_check import contradiction
from slam.backend.pose_graph import PoseEdge
from slam.backend.submap_merging import MergeHypothesis, SubmapMerging
from slam.frontend.color_calibration import ColorCamera
from slam.frontend.features import FeatureExtractor, faint_texture, in_image
from slam.frontend.keyframes import View

CAMERA = Intrinsics(320, 240, 260.0, 260.0, 159.5, 119.5)


def shift(z_m):
    result = np.eye(4)
    result[2, 3] = z_m
    return result


def corridor(end_m, half_m=1.0):
    """The depth of a square corridor along the camera's axis that ends after some metres."""
    rows, columns = np.mgrid[0:240, 0:320]
    slant = np.maximum(np.abs((columns - 159.5) / 260.0), np.abs((rows - 119.5) / 260.0))
    return np.minimum(half_m / np.maximum(slant, 1e-9), end_m).astype(np.float32)


def view(depth):
    frame = Frame(0, 0.0, np.zeros((240, 320, 3), np.uint8), depth, CAMERA)
    return View.of(frame, FeatureExtractor(), ColorCamera.nominal())


def test_two_true_views_do_not_contradict_each_other():
    assert contradiction(view(corridor(8.0)), view(corridor(6.0)), shift(2.0)) == 0.0


def test_a_corridor_gives_itself_away_by_its_end_beyond_the_reach_of_registration():
    # Walls, floor and ceiling agree at any shift along the corridor; its end, 6 m away, agrees at one only.
    along = contradiction(view(corridor(8.0)), view(corridor(6.0)), shift(0.0))
    true_share = np.mean(corridor(6.0) == 6.0)
    assert along == pytest.approx(true_share, rel=0.25)
    # Where the submap would stand too far back, it is the other view that contradicts.
    assert contradiction(view(corridor(6.0)), view(corridor(8.0)), shift(0.0)) == pytest.approx(along)


def test_what_was_not_read_contradicts_nothing():
    holes = corridor(8.0)
    holes[holes > 6.0] = 0.0
    assert contradiction(view(holes), view(corridor(6.0)), np.eye(4)) == 0.0


def hypothesis(frame, z_m, strength=1.0):
    return MergeHypothesis(frame, PoseEdge(0, 9, np.eye(4), np.eye(6)), shift(z_m), strength)


def test_three_views_that_agree_tie_a_piece_the_strongest_first():
    ties = SubmapMerging()
    assert not ties.add(0, 1, hypothesis(5, 2.0, 0.4))
    assert not ties.add(0, 1, hypothesis(6, 2.1, 0.9))
    agreeing = ties.add(0, 1, hypothesis(7, 2.05, 0.6))
    assert [w.strength for w in agreeing] == [0.9, 0.6, 0.4]


def test_one_view_counts_once_however_many_keyframes_it_fits():
    ties = SubmapMerging()
    assert not any(ties.add(0, 1, hypothesis(5, 2.0)) for _ in range(6))


def test_places_that_look_alike_wait_for_a_majority():
    ties = SubmapMerging()
    for frame in range(3):
        assert not ties.add(0, 1, hypothesis(frame, 0.0)) or frame == 2
    ties = SubmapMerging()
    for frame in range(2):
        ties.add(0, 1, hypothesis(frame, 0.0))
        ties.add(0, 1, hypothesis(frame, 2.26))
    assert not ties.add(0, 1, hypothesis(2, 2.26))  # three against two
    assert len(ties.add(0, 1, hypothesis(3, 2.26))) == 4


def test_pairs_of_pieces_are_told_apart_and_forgotten_with_a_submap():
    ties = SubmapMerging()
    for frame, submap in ((1, 1), (2, 2), (3, 1)):
        assert not ties.add(0, submap, hypothesis(frame, 0.0))
    ties.forget(1)
    assert not ties.add(0, 1, hypothesis(4, 0.0))
    assert not ties.add(0, 2, hypothesis(5, 0.0))
    assert ties.add(0, 2, hypothesis(6, 0.0))


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
    assert len(FeatureExtractor().find(frame, ColorCamera.nominal())) > 300
    # A gradient is shading, not texture.
    shaded = np.tile(np.linspace(50, 200, 320), (240, 1)).astype(np.uint8)
    assert np.abs(faint_texture(shaded)[20:-20, 20:-20].astype(int) - 128).max() <= 8
