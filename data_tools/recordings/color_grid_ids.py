"""Instance ids that were drawn on the colour image, looked up where each depth pixel's point lies in it."""

from __future__ import annotations

import cv2
import numpy as np

from data_tools.recordings.images import size_of
from data_tools.recordings.rgbd_alignment import RgbdAlignment
from razer.arrays import Float32Array, Int32Array, Uint16Array
from razer.errors import UnusableFrame

_SAME_ASPECT = 0.02  # ScanNet's 1296x968 and 640x480, between which images are often resized, differ by 0.4 %


def ids_on_depth_grid(ids: Uint16Array, alignment: RgbdAlignment, depth: Float32Array, label: str) -> Int32Array:
    """Ids of the colour image, at its size or another of its shape, on the grid of the aligned depth (H, W), metres.
    Each pixel has the id of the nearest one, never one between two; 0 where there is no depth to look through, or the
    colour camera does not see it. Raises UnusableFrame naming `label` for an image of another shape."""
    width, height = size_of(ids)
    full_width, full_height = alignment.color_size
    if abs(width * full_height / (height * full_width) - 1) > _SAME_ASPECT:
        raise UnusableFrame(f"{label} is {width}x{height}, but the colour image is {full_width}x{full_height}")
    size = alignment.color_size if alignment.warp is not None else alignment.depth_size
    if (width, height) != size:
        ids = cv2.resize(ids, size, interpolation=cv2.INTER_NEAREST_EXACT)
    if alignment.color_map is not None:
        ids = alignment.color_map.nearest(ids)
    if alignment.warp is None:
        return ids.astype(np.int32)
    return alignment.warp.nearest(ids, depth).astype(np.int32)
