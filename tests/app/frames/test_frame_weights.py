"""Frames of uncertain poses count less in the map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.frames.frame_weights import MIN_WEIGHT, frame_weights
from slam.report import GraphReport

NOTHING = GraphReport(
    np.zeros(0, np.int64), np.zeros(0), np.zeros((0, 4, 4)), np.zeros((0, 2), np.int64), np.zeros(0, bool), 0, 0, {}
)


def weights(sigmas_m, indices=range(0, 50, 5)):
    return frame_weights(replace(NOTHING, local_sigmas_m=sigmas_m), indices, voxel_size_m=0.02)


def test_only_frames_whose_poses_are_off_by_a_voxel_count_less():
    assert weights({0: 0.001, 20: 0.01}) == {}
    assert weights({0: 0.001, 20: 0.02, 30: 0.002}) == {20: 0.5, 25: 0.5}


def test_the_least_weight_keeps_what_nobody_else_sees():
    assert set(weights({0: 3.0}).values()) == {MIN_WEIGHT}


def test_frames_before_all_keyframes_count_in_full():
    assert weights({30: 1.0}, [0, 10, 29]) == {}


@pytest.mark.parametrize("sigma_voxels", [0.1, 0.5, 0.9, 1.3, 2.0, 9.0])
def test_weights_are_powers_of_two(sigma_voxels):
    weight = weights({0: 0.02 * sigma_voxels}).get(0, 1.0)
    assert np.log2(weight) == round(np.log2(weight))
    assert weight == pytest.approx(max(1 / (1 + sigma_voxels**2), MIN_WEIGHT), rel=0.42)
