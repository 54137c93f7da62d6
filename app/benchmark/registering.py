"""Benchmark of colour registration: one lookup of colour through depth, beside one plain remap of the image."""

from __future__ import annotations

import cv2
import numpy as np

from app.benchmark.repeated_timing import median_ms
from data_tools.recordings.color_warp import ColorWarp
from data_tools.recordings.rgbd_calibration import RgbdCalibration
from razer.frame import Intrinsics

_CAMERA = Intrinsics(640, 480, 525.0, 525.0, 319.5, 239.5)
_COLOR = Intrinsics(640, 480, 475.0, 475.0, 321.0, 236.0)
_BASELINE_M = 0.03


def measure_registering() -> dict[str, float]:
    """Milliseconds, median of 30 rounds, to bring a colour image of 640x480 onto depth, occlusion respected; and how
    that compares with one remap of the image by a fixed table."""
    rng = np.random.default_rng(0)
    rgb = rng.integers(0, 255, (480, 640, 3), np.uint8)
    depth = cv2.resize(rng.uniform(0.8, 4, (12, 16)).astype(np.float32), (640, 480), interpolation=cv2.INTER_NEAREST)
    depth[rng.random(depth.shape) < 0.1] = 0
    color_from_depth = np.eye(4)
    color_from_depth[0, 3] = -_BASELINE_M
    warp = ColorWarp.between(_CAMERA, RgbdCalibration(_COLOR, color_from_depth))
    x, y = np.meshgrid(np.arange(640, dtype=np.float32), np.arange(480, dtype=np.float32))
    registering_ms = median_ms(lambda: warp.apply(rgb, depth))
    remap_ms = median_ms(lambda: cv2.remap(rgb, x + np.float32(0.3), y, cv2.INTER_LINEAR))
    return {"median_ms": round(registering_ms, 2), "to_remap": round(registering_ms / remap_ms, 2)}
