"""Writer of .sens files of ScanNet, version 4, frame by frame."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import BinaryIO

import numpy as np

from data_tools.readers.scannet.sens_file import BODY, COLOR_KINDS, DEPTH_KINDS, FRAME_HEAD, NAME, VERSION
from data_tools.writers.frame_files import depth_units, encoded_color
from razer.frame import Frame, Intrinsics

_COUNT = struct.Struct("<Q")
_KIND_BY_SUFFIX = {".jpg": "jpeg", ".png": "png"}


def write_sens_file(
    path: Path, frames: Iterable[Frame], camera: Intrinsics, *, sensor: str, suffix: str, units_per_metre: float
) -> int:
    """Write frames and return how many: depth in zlib, stamps in microseconds, no inertial measurements.

    Args:
        path: the file.
        frames: their colour, depth, poses and stamps; -inf is written for poses that are unknown.
        camera: of colour and depth, which share one grid.
        sensor: its name, for the header.
        suffix: .jpg or .png: how colour is encoded.
        units_per_metre: of the 16-bit depth.
    """
    count = 0
    with path.open("wb") as file:
        _write_header(file, camera, sensor, _KIND_BY_SUFFIX[suffix], units_per_metre)
        start = file.tell()
        for frame in frames:
            _write_frame(file, frame, suffix, units_per_metre)
            count += 1
        file.write(_COUNT.pack(0))
        file.seek(start - _COUNT.size)
        file.write(_COUNT.pack(count))
    return count


def _write_header(file: BinaryIO, camera: Intrinsics, sensor: str, color_kind: str, units_per_metre: float) -> None:
    """The header with 0 frames; their number is its end."""
    intrinsic = np.eye(4)
    intrinsic[:3, :3] = camera.matrix
    matrices = np.stack([intrinsic, np.eye(4)] * 2)
    kinds = [_number(COLOR_KINDS, color_kind), _number(DEPTH_KINDS, "zlib_ushort")]
    size = (camera.width, camera.height)
    name = sensor.encode()
    file.write(NAME.pack(VERSION, len(name)) + name)
    file.write(BODY.pack(*matrices.ravel(), *kinds, *size, *size, units_per_metre, 0))


def _write_frame(file: BinaryIO, frame: Frame, suffix: str, units_per_metre: float) -> None:
    color = encoded_color(frame.rgb, suffix)
    depth = zlib.compress(depth_units(frame.depth, units_per_metre).astype("<u2").tobytes())
    head = np.zeros(1, FRAME_HEAD)
    head["pose"] = -np.inf if frame.world_from_camera is None else frame.world_from_camera
    head["color_us"] = head["depth_us"] = max(round(frame.stamp * 1e6), 0)
    head["sizes"] = len(color), len(depth)
    file.write(head.tobytes() + color + depth)


def _number(kinds: dict[int, str], wanted: str) -> int:
    return next(number for number, kind in kinds.items() if kind == wanted)
