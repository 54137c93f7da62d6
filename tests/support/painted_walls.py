"""Painted walls as a camera sees them, in one light and in another."""

from __future__ import annotations

import numpy as np

from razer.frame import Frame, Intrinsics
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import FeatureExtractor
from slam.frontend.keyframes import STILL, View

CAMERA = Intrinsics(320, 240, 260.0, 260.0, 159.5, 119.5)
CONFIG = SlamConfig()
HERE = np.eye(4)


def wall(shift=0):
    """Depth and colours of a wall two metres away, with broad stripes of three colours, some pixels aside."""
    stripe = ((np.arange(320) + shift) // 40) % 3
    colors = np.array([(200, 60, 50), (60, 160, 70), (50, 70, 190)], np.uint8)
    return np.broadcast_to(colors[stripe], (240, 320, 3)), np.full((240, 320), 2.0, np.float32)


def view(rgb, depth):
    frame = Frame(0, 0.0, np.ascontiguousarray(rgb, np.uint8), depth, CAMERA)
    return View.of(frame, FeatureExtractor(CONFIG).extract(frame, ColorCalibration.nominal()), STILL, CONFIG)


def plaster():
    """Colours of a wall with stripes of three that are nearly grey, and its depth."""
    stripe = (np.arange(320) // 16) % 3
    colors = np.array([(170, 160, 150), (120, 125, 115), (95, 100, 110)], float)
    return np.broadcast_to(colors[stripe], (240, 320, 3)), wall()[1]


def lit_otherwise(rgb):
    """By a lamp on the right, which leaves a tenth of a wall in the shadow of a board."""
    return with_board(rgb * np.linspace(0.6, 1.0, 320)[:, None])


def with_board(rgb):
    darker = rgb.copy()
    darker[60:136, 60:160] *= 0.4
    return darker


def painted(rgb, columns):
    other = rgb.copy()
    other[:, :columns] *= (0.7, 1.0, 1.3)
    return other
