"""Decoding of image files: colour, depth and instance ids, in OpenCV, which lets other threads work."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.arrays import Float32Array, Int32Array, Uint8Array, Uint16Array
from razer.errors import BadInput, UnusableFrame
from razer.files import MissingFile, decode_image, read_bytes

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg")
SATURATED = 65535  # 7-Scenes marks missing depth with it; elsewhere it is the largest value a PNG holds
MAX_FRAME_BYTES = 256 * 2**20  # of one file of one frame
# The EXIF orientation is ignored because depth, which has none, must stay on the same grid.
_RGB = cv2.IMREAD_COLOR_RGB | cv2.IMREAD_IGNORE_ORIENTATION


def read_rgb(path: Path) -> Uint8Array:
    """A colour image, (H, W, 3) uint8 in RGB order; raises UnusableFrame."""
    return _decode(path, _RGB)


def decode_rgb(data: bytes, name: str) -> Uint8Array:
    """The colour image in the bytes of a PNG or JPEG file, (H, W, 3) in RGB order; raises UnusableFrame."""
    return decode(data, name, _RGB)


def read_depth(path: Path, units_per_metre: float) -> Float32Array:
    """A 16-bit depth image in metres, (H, W) float32, 0 = no reading (0 and 65535 in the file); raises
    UnusableFrame, also for an image without any reading."""
    depth = metres(_single_channel(path, "depth", np.uint16), units_per_metre)
    if not depth.any():
        raise UnusableFrame(f"{short_name(path)} holds no valid depth: every pixel is 0 or {SATURATED}")
    return depth


def metres(raw: Uint16Array, units_per_metre: float) -> Float32Array:
    """Depth in metres, 0 = no reading, of depth in units, where 0 and 65535 mean no reading."""
    depth = np.divide(raw, np.float32(units_per_metre), dtype=np.float32)
    depth[raw == SATURATED] = 0
    return depth


def read_ids(path: Path) -> Int32Array:
    """A 16-bit image of instance ids, (H, W) int32, 0 = nobody; raises UnusableFrame."""
    return _single_channel(path, "instance ids", np.uint16).astype(np.int32)


def read_parts(path: Path) -> Uint8Array:
    """An 8-bit image of the parts of instances, (H, W), 0 = of none; raises UnusableFrame."""
    return _single_channel(path, "parts", np.uint8)


def short_name(path: Path) -> str:
    """The last folder and the name: enough to find the file within its recording."""
    return f"{path.parent.name}/{path.name}"


def size_of(image: NDArray) -> tuple[int, int]:
    """(width, height) of an image array."""
    return image.shape[1], image.shape[0]


def _single_channel(path: Path, what: str, kind: type[np.uint8] | type[np.uint16]) -> NDArray:
    image = _decode(path, cv2.IMREAD_UNCHANGED)
    if image.ndim != 2 or image.dtype != kind:
        channels = 1 if image.ndim == 2 else image.shape[2]
        raise UnusableFrame(
            f"{short_name(path)} has {channels} channel(s) of {image.dtype}: "
            f"{what} must be {'a 16' if kind is np.uint16 else 'an 8'}-bit PNG with one channel"
        )
    return image


def decode(data: bytes, name: str, flags: int) -> NDArray:
    """The image in the bytes of a PNG or JPEG file, see `razer.files.decode_image`; raises UnusableFrame."""
    with unusable_frame():
        return decode_image(data, name, flags)


def read_member(path: Path) -> bytes:
    """The bytes of one file of a recording; raises UnusableFrame naming it within the recording."""
    with unusable_frame():
        try:
            return read_bytes(path, MAX_FRAME_BYTES)
        except MissingFile:
            raise UnusableFrame(f"{short_name(path)} is missing") from None


@contextmanager
def unusable_frame() -> Iterator[None]:
    """What is bad input in the block is so for one frame only, which raises UnusableFrame."""
    try:
        yield
    except UnusableFrame:
        raise
    except BadInput as error:
        raise UnusableFrame(str(error)) from None


def _decode(path: Path, flags: int) -> NDArray:
    return decode(read_member(path), short_name(path), flags)
