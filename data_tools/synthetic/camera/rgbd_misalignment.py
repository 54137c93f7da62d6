"""RGB-D misalignment: a colour camera of another focal length and at another place than that of depth.

Recordings declare one camera for both images, also where they were taken by two (the raw Kinect of 7-Scenes).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from data_tools.truth.rgbd_calibration import RgbdCalibration
from razer.arrays import Float64Array
from razer.errors import BadInput
from razer.frame import Intrinsics

ZOOM = (0.5, 2.0)
MAX_SHIFT = 0.5  # share of the image
MAX_BASELINE_M = 0.5


@dataclass(frozen=True, slots=True)
class RgbdMisalignment:
    """How the colour camera differs from the depth camera, both pinholes that look the same way.

    A far point that depth shows at pixel p, from the middle of the image, lies at zoom p + shift_px in colour; the
    colour camera stands at baseline_m (x right, y down, z forward) in the depth camera. Raises BadInput for what is
    not finite, or differs so much that the two would hardly see the same.
    """

    zoom: float = 1.0
    shift_px: tuple[float, float] = (0.0, 0.0)
    baseline_m: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not ZOOM[0] <= self.zoom <= ZOOM[1]:
            raise BadInput(f"a colour zoom of {self.zoom:g} is impossible: give {ZOOM[0]:g} to {ZOOM[1]:g}")
        if not np.isfinite(self.shift_px).all():
            raise BadInput(f"a colour shift of {self.shift_px} pixels is impossible: give two numbers")
        if not np.linalg.norm(self.baseline_m) <= MAX_BASELINE_M:
            raise BadInput(f"a colour baseline of {self.baseline_m} m is impossible: give {MAX_BASELINE_M:g} m or less")

    @property
    def is_none(self) -> bool:
        """Whether colour and depth are seen by one camera."""
        return self == RgbdMisalignment()

    def calibration(self, depth: Intrinsics) -> RgbdCalibration:
        """The colour camera beside a depth camera of the same image size; raises BadInput where the shift leaves
        little of the image."""
        size, shift = np.array([depth.width, depth.height]), np.array(self.shift_px)
        if (np.abs(shift) > MAX_SHIFT * size).any():
            raise BadInput(f"a colour shift of {self.shift_px} pixels is impossible: images are {size[0]}x{size[1]}")
        middle = (size - 1) / 2
        cx, cy = (middle + self.zoom * (np.array([depth.cx, depth.cy]) - middle) + shift).tolist()
        color = Intrinsics(depth.width, depth.height, self.zoom * depth.fx, self.zoom * depth.fy, cx, cy)
        return RgbdCalibration(color, self._color_from_depth())

    def _color_from_depth(self) -> Float64Array:
        transform = np.eye(4)
        transform[:3, 3] -= self.baseline_m
        return transform
