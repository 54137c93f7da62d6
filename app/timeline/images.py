"""Image encoding for the timeline: scaled down, with the intrinsics that belong to them."""

from __future__ import annotations

import math

import cv2
import numpy as np

from razer.arrays import Float32Array, Uint8Array
from razer.frame import Intrinsics


def scaled_to(camera: Intrinsics, max_edge: int) -> Intrinsics:
    """The camera scaled down, if need be, so that no edge is longer than `max_edge` pixels."""
    scale = min(1.0, max_edge / max(camera.width, camera.height))
    return camera.resized(round(scale * camera.width), round(scale * camera.height))


def subsampling_step(camera: Intrinsics, max_edge: int) -> int:
    """Every how many pixels one has to be kept so that no edge is longer than `max_edge` pixels."""
    return math.ceil(max(camera.width, camera.height) / max_edge)


def every_nth(camera: Intrinsics, n: int) -> Intrinsics:
    """The camera whose image is every n-th pixel of every n-th row, from the first on."""
    size = math.ceil(camera.width / n), math.ceil(camera.height / n)
    return Intrinsics(*size, camera.fx / n, camera.fy / n, camera.cx / n, camera.cy / n)


def jpeg(rgb: Uint8Array, camera: Intrinsics, quality: int) -> bytes:
    """An (H, W, 3) colour image at the size of `camera` as JPEG."""
    size = (camera.width, camera.height)
    small = rgb if rgb.shape[1::-1] == size else cv2.resize(rgb, size, interpolation=cv2.INTER_AREA)
    bgr = cv2.cvtColor(small, cv2.COLOR_RGB2BGR)
    return cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()


def depth_png(depth_m: Float32Array) -> bytes:
    """An (H, W) depth image in metres as 16-bit PNG in millimetres; beyond 65.5 m counts as no reading."""
    millimetres = np.rint(depth_m * 1000)
    encoded = np.where(millimetres < 2**16, millimetres, 0).astype(np.uint16)
    return cv2.imencode(".png", encoded, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1].tobytes()
