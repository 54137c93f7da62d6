"""RGB-D calibration: the camera that colour was taken with, and where it stood in that of depth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from razer.arrays import Float64Array
from razer.errors import BadInput
from razer.files import MALFORMED, MissingFile, read_json
from razer.frame import Intrinsics
from razer.geometry import is_rigid

FILE_NAME = "rgbd_calibration.json"
MAX_BASELINE_M = 1.0  # no device is as wide; millimetres taken for metres are beyond


@dataclass(frozen=True, slots=True)
class RgbdCalibration:
    """color: the pinhole camera of the colour images; color_from_depth (4, 4): takes points of the depth camera to the
    colour camera, metres."""

    color: Intrinsics
    color_from_depth: Float64Array

    def to_json(self) -> dict[str, Any]:
        """What rgbd_calibration.json holds."""
        return {"color": asdict(self.color), "color_from_depth": self.color_from_depth.tolist()}


def read_rgbd_calibration(path: Path) -> RgbdCalibration:
    """The calibration in a file that `RgbdCalibration.to_json` describes; raises BadInput naming the file."""
    try:
        content = read_json(path)
        color = _camera(content["color"])
        color_from_depth = np.array(content["color_from_depth"], np.float64)
    except MissingFile:
        raise BadInput(
            f"{path} cannot be read (No such file or directory): give auto, off or a calibration file"
        ) from None
    except MALFORMED as error:
        raise BadInput(
            f'{path} must be JSON with "color" (width, height, fx, fy, cx, cy) and "color_from_depth", a 4x4 matrix, '
            f"as `razer inspect --write` makes it (problem: {error})"
        ) from None
    if color_from_depth.shape != (4, 4) or not is_rigid(color_from_depth, tolerance=1e-3):
        raise BadInput(f"{path}: color_from_depth must be a rigid 4x4 matrix, metres")
    if (apart_m := float(np.linalg.norm(color_from_depth[:3, 3]))) > MAX_BASELINE_M:
        raise BadInput(f"{path}: the cameras would stand {apart_m:g} m apart: give color_from_depth in metres")
    return RgbdCalibration(color, color_from_depth)


def _camera(content: Mapping[str, Any]) -> Intrinsics:
    width, height = int(content["width"]), int(content["height"])
    return Intrinsics(width, height, *(float(content[name]) for name in ("fx", "fy", "cx", "cy")))
