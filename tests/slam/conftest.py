"""Fixtures of the tests of the pose estimation."""

from __future__ import annotations

import numpy as np
import pytest

from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import FeatureExtractor
from slam.frontend.keyframes import STILL, View


@pytest.fixture
def rng():
    return np.random.default_rng(7)


@pytest.fixture(scope="module")
def room():
    return SyntheticScene("room", 3, 60, sensor=SensorModel.kinect())


@pytest.fixture(scope="module")
def views(room):
    config, calibration = SlamConfig(), ColorCalibration.nominal()
    extractor = FeatureExtractor(config)
    return {i: View.of(room[i], extractor.extract(room[i], calibration), STILL, config) for i in (10, 12)}
