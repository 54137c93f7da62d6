"""Registration of colour to depth as a file says it, such as that of a finished run."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from data_tools.recordings.color_warp import ColorWarp
from data_tools.recordings.rgbd_calibration import FILE_NAME, RgbdCalibration, read_rgbd_calibration
from razer.errors import BadInput
from razer.frame import Intrinsics


def read_calibration_for(path: Path, depth_camera: Intrinsics) -> RgbdCalibration | None:
    """The calibration in a file, for images of a depth camera's size; None where it says that the two are one; raises
    BadInput."""
    calibration = read_rgbd_calibration(path)
    size, color = (depth_camera.width, depth_camera.height), calibration.color
    if color.width * size[1] != color.height * size[0]:
        raise BadInput(
            f"{path} is for colour of {color.width}x{color.height}, but the images are {size[0]}x{size[1]}: "
            "give the file of this recording"
        )
    calibration = RgbdCalibration(color.resized(*size), calibration.color_from_depth)
    is_one = calibration.color == depth_camera and bool((calibration.color_from_depth == np.eye(4)).all())
    return None if is_one else calibration


def registration_of_run(run: Path, depth_camera: Intrinsics) -> ColorWarp | None:
    """What brought colour onto depth in a finished run; None where nothing did."""
    path = run / FILE_NAME
    calibration = read_calibration_for(path, depth_camera) if path.is_file() else None
    return None if calibration is None else ColorWarp.between(depth_camera, calibration)
