"""Image encoding for the timeline: scaled down, with the intrinsics that belong to them."""

from __future__ import annotations

import math
from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from app.render.name_tags import write_names
from app.render.palette import instance_colors
from razer.arrays import BoolArray, Float32Array, Int32Array, Uint8Array
from razer.frame import Intrinsics

TINT = 0.35  # of an instance's colour in its part of an image
NAMED_IN_IMAGE = 12


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


def resized(image: NDArray, camera: Intrinsics, interpolation: int = cv2.INTER_AREA) -> NDArray:
    """An image (H, W, ...) at the size of `camera`."""
    size = (camera.width, camera.height)
    return image if image.shape[1::-1] == size else cv2.resize(image, size, interpolation=interpolation)


def jpeg(rgb: Uint8Array, quality: int) -> bytes:
    """An (H, W, 3) colour image as JPEG."""
    bgr = cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR)
    return cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()


def depth_png(depth_m: Float32Array) -> bytes:
    """An (H, W) depth image in metres as 16-bit PNG in millimetres; beyond 65.5 m counts as no reading."""
    millimetres = np.rint(depth_m * 1000)
    encoded = np.where(millimetres < 2**16, millimetres, 0).astype(np.uint16)
    return cv2.imencode(".png", encoded, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1].tobytes()


def instance_overlay(rgb: Uint8Array, ids: Int32Array, names: Mapping[int, str]) -> Uint8Array:
    """A colour image (H, W, 3) in which every instance of `ids` (H, W) is tinted and outlined in its colour, and the
    largest are named."""
    colors = instance_colors(np.arange(int(ids.max(initial=0)) + 1))[ids]
    known = ids > 0
    tinted = np.where(known[..., None], (1 - TINT) * rgb + TINT * colors, rgb).astype(np.uint8)
    tinted[_outlines(ids)] = colors[_outlines(ids)]
    present, pixels = np.unique(ids[known], return_counts=True)
    largest = present[np.argsort(-pixels, kind="stable")][:NAMED_IN_IMAGE].tolist()
    write_names(tinted, ids, {instance: names[instance] for instance in largest if instance in names})
    return tinted


def _outlines(ids: Int32Array) -> BoolArray:
    """Where an instance (H, W) ends: its pixels that have a neighbour of another one."""
    edge = np.zeros(ids.shape, np.bool_)
    for axis in (0, 1):
        differs = np.diff(ids, axis=axis) != 0
        before = np.pad(differs, [(0, 1) if a == axis else (0, 0) for a in (0, 1)])
        after = np.pad(differs, [(1, 0) if a == axis else (0, 0) for a in (0, 1)])
        edge |= before | after
    return edge & (ids > 0)
