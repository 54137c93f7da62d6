"""Encoding of colour, depth and instance ids as image files, for the writers of all layouts."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from data_tools.recordings.sequence import RgbdSequence, usable_frames
from razer.arrays import Float32Array, Float64Array, Uint8Array, Uint16Array
from razer.errors import BadInput
from razer.frame import Frame

_JPEG_QUALITY = 95
_LARGEST = 65534  # units in a 16-bit depth image; 65535 stands for no reading with some readers


def frames_to_write(sequence: RgbdSequence, skipped: list[tuple[int, str]]) -> Iterator[Frame]:
    """The frames that can be used, in order; (index, reason) of each other one is added to `skipped`. Raises
    BadInput at the end where there was none at all."""
    yield from usable_frames(sequence, lambda index, reason: skipped.append((index, reason)))
    if len(skipped) == len(sequence):
        first = f", first frame {skipped[0][0]}: {skipped[0][1]}" if skipped else ""
        raise BadInput(f"{sequence.name}: none of {len(sequence)} frames can be used{first}")


def write_color(path: Path, rgb: Uint8Array) -> None:
    """(H, W, 3) in RGB order as JPEG of quality 95 or as PNG, by the suffix."""
    _write(path, encoded_color(rgb, path.suffix))


def encoded_color(rgb: Uint8Array, suffix: str) -> bytes:
    """What write_color writes into a file with this suffix."""
    return _encoded(cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), suffix)


def write_depth(path: Path, depth: Float32Array, units_per_metre: float, none: int = 0) -> None:
    """Write depth in the units of depth_units as 16-bit PNG.

    Args:
        path: the file.
        depth: (H, W) metres, 0 = no reading.
        units_per_metre: of the file.
        none: what is written where there is no reading.
    """
    _write(path, _encoded(depth_units(depth, units_per_metre, none), path.suffix))


def depth_units(depth: Float32Array, units_per_metre: float, none: int = 0) -> Uint16Array:
    """(H, W) in metres in the given units, rounded; `none` where there is no reading or one beyond 65534 units."""
    units = np.rint(depth.astype(np.float64) * units_per_metre)
    return np.where((units > 0) & (units <= _LARGEST), units, none).astype(np.uint16)


def write_ids(path: Path, frame: Frame) -> None:
    """The instance ids of a frame as 16-bit PNG, 0 = nobody; raises BadInput for ids above 65535."""
    assert frame.instance_ids is not None
    if frame.instance_ids.max(initial=0) > np.iinfo(np.uint16).max:
        raise BadInput(f"frame {frame.index} has instance ids above 65535, which {path.parent.name}/ cannot hold")
    _write(path, _encoded(frame.instance_ids.clip(0).astype(np.uint16), path.suffix))


def write_parts(path: Path, part_ids: Uint8Array) -> None:
    """The part of its instance (H, W) that each pixel shows as 8-bit PNG, 0 = none."""
    _write(path, _encoded(part_ids, path.suffix))


def matrix_lines(matrix: Float64Array) -> str:
    """The rows of a matrix, a line each, to nine digits."""
    return "".join(" ".join(f"{x:.9g}" for x in row) + "\n" for row in matrix)


def _write(path: Path, data: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


def _encoded(image: NDArray, suffix: str) -> bytes:
    options = [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY] if suffix == ".jpg" else []
    return cv2.imencode(suffix, image, options)[1].tobytes()
