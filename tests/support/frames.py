"""What can be said of frames."""

from __future__ import annotations

import numpy as np

from razer.frame import Frame
from razer.geometry import back_project, transform_points


def world_points(frame: Frame) -> np.ndarray:
    v, u = np.mgrid[: frame.intrinsics.height, : frame.intrinsics.width]
    return transform_points(frame.pose, back_project(u, v, frame.depth.astype(float), frame.intrinsics.matrix))
