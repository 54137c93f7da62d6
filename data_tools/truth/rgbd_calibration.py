"""True RGB-D calibration: the camera that colour was taken with, and where it stood in that of depth."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from razer.arrays import Float64Array
from razer.frame import Intrinsics

FILE_NAME = "rgbd_calibration.json"


@dataclass(frozen=True, slots=True)
class RgbdCalibration:
    """color: the pinhole camera of the colour images; color_from_depth (4, 4): takes points of the depth camera to the
    colour camera, metres."""

    color: Intrinsics
    color_from_depth: Float64Array

    def to_json(self) -> dict[str, Any]:
        """What rgbd_calibration.json holds."""
        return {"color": asdict(self.color), "color_from_depth": self.color_from_depth.tolist()}
