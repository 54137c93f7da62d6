"""Images in ROS messages: sensor_msgs Image and CompressedImage, and compressed_depth_image_transport.

Source of the last: a 12-byte header (int32 format, float32 a, float32 b) before a 16-bit PNG that holds depth for
16UC1, and for 32FC1 the value v of depth = a / (v - b);
https://docs.ros.org/en/api/compressed_depth_image_transport/html/codec_8cpp_source.html
"""

from __future__ import annotations

import struct
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from data_tools.recordings.images import decode, decode_rgb
from razer.arrays import Float32Array, Uint8Array
from razer.errors import UnusableFrame

_MILLIMETRES = 1000.0
_SATURATED = 65535
_PNG = b"\x89PNG"
_HEADER = struct.Struct("<iff")
_TO_RGB = {
    "rgb8": None,
    "bgr8": cv2.COLOR_BGR2RGB,
    "8uc3": cv2.COLOR_BGR2RGB,
    "rgba8": cv2.COLOR_RGBA2RGB,
    "bgra8": cv2.COLOR_BGRA2RGB,
    "8uc4": cv2.COLOR_BGRA2RGB,
    "mono8": cv2.COLOR_GRAY2RGB,
    "8uc1": cv2.COLOR_GRAY2RGB,
    "yuv422_yuy2": cv2.COLOR_YUV2RGB_YUY2,
    "yuv422": cv2.COLOR_YUV2RGB_UYVY,
}
_CHANNELS = {"rgba8": 4, "bgra8": 4, "8uc4": 4, "mono8": 1, "8uc1": 1, "yuv422_yuy2": 2, "yuv422": 2}
_DEPTH_TYPES = {"16uc1": np.uint16, "mono16": np.uint16, "32fc1": np.float32}


def is_depth(message: Any) -> bool:
    """Whether an image message holds depth, by its encoding or format."""
    if hasattr(message, "encoding"):
        return message.encoding.lower() in _DEPTH_TYPES
    return "compresseddepth" in message.format.lower() or message.format.lower().startswith(("16uc1", "32fc1"))


def color_of(message: Any, name: str) -> Uint8Array:
    """(H, W, 3) in RGB order; raises UnusableFrame naming the topic."""
    if not hasattr(message, "encoding"):
        return decode_rgb(bytes(message.data), name)
    encoding = message.encoding.lower()
    if encoding not in _TO_RGB:
        raise UnusableFrame(f"{name} has the encoding {message.encoding}, which is not read: republish it as rgb8")
    image = _pixels(message, np.dtype(np.uint8), _CHANNELS.get(encoding, 3), name)
    code = _TO_RGB[encoding]
    return np.ascontiguousarray(image) if code is None else cv2.cvtColor(np.ascontiguousarray(image), code)


def depth_of(message: Any, name: str) -> Float32Array:
    """(H, W) in metres, 0 = no reading; raises UnusableFrame naming the topic."""
    if not hasattr(message, "encoding"):
        return _compressed_depth(message, name)
    kind = _DEPTH_TYPES.get(message.encoding.lower())
    if kind is None:
        raise UnusableFrame(f"{name} has the encoding {message.encoding}: depth must be 16UC1 or 32FC1")
    order: Literal["<", ">"] = ">" if message.is_bigendian else "<"
    return _metres(_pixels(message, np.dtype(kind).newbyteorder(order), 1, name)[..., 0])


def _pixels(message: Any, kind: np.dtype, channels: int, name: str) -> NDArray:
    """(H, W, channels) without the padding at the end of each row."""
    width = message.width * channels * kind.itemsize
    data = np.asarray(message.data, dtype=np.uint8)
    if message.step < width or data.size < message.step * message.height:
        raise UnusableFrame(f"{name}: {data.size} bytes are too few for {message.width}x{message.height}")
    rows = data[: message.step * message.height].reshape(message.height, message.step)[:, :width]
    return np.ascontiguousarray(rows).view(kind).reshape(message.height, message.width, channels)


def _compressed_depth(message: Any, name: str) -> Float32Array:
    data = bytes(message.data)
    start = data.find(_PNG, 0, _HEADER.size + len(_PNG))
    if start < 0:
        raise UnusableFrame(f"{name} is compressed as '{message.format}': only PNG is read for depth")
    values = decode(data[start:], name, cv2.IMREAD_UNCHANGED)
    if values.dtype != np.uint16 or values.ndim != 2:
        raise UnusableFrame(f"{name} holds {values.dtype} images: depth must be 16-bit with one channel")
    if start == _HEADER.size and message.format.lower().startswith("32fc1"):
        _, a, b = _HEADER.unpack(data[:start])
        with np.errstate(divide="ignore"):
            return _metres(np.where(values > 0, a / (values.astype(np.float32) - b), 0).astype(np.float32))
    return _metres(values)


def _metres(values: NDArray) -> Float32Array:
    if values.dtype.kind == "u":
        depth = (values / np.float32(_MILLIMETRES)).astype(np.float32)
        depth[values == _SATURATED] = 0
        return depth
    depth = values.astype(np.float32)
    depth[~(np.isfinite(depth) & (depth > 0))] = 0
    return depth
