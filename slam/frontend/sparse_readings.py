"""Sparse readings: a few of a frame's depths, far ones among them, with their colours."""

from __future__ import annotations

import cv2
import numpy as np

from razer.arrays import Float16Array, Uint8Array
from razer.frame import Frame, Intrinsics

FARTHEST_M = float(np.finfo(np.float16).max)


def sparse_readings(frame: Frame, width: int) -> tuple[Float16Array, Uint8Array, Intrinsics]:
    """One depth, as it is, of every few pixels of a frame, about `width` across, the mean colour about each, and the
    camera that sees these alone. Depth is kept to a two-thousandth of itself."""
    k = frame.intrinsics
    step = max(1, round(k.width / width))
    first = step // 2
    depth = frame.depth[first::step, first::step].clip(max=FARTHEST_M).astype(np.float16)
    rgb = np.ascontiguousarray(cv2.blur(frame.rgb, (step, step))[first::step, first::step])
    middle = (k.cx - first) / step, (k.cy - first) / step
    return depth, rgb, Intrinsics(depth.shape[1], depth.shape[0], k.fx / step, k.fy / step, *middle)
