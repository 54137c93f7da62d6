"""Axis-aligned bounding boxes of masks."""

from __future__ import annotations

import numpy as np

from razer.arrays import BoolArray, Float64Array


def mask_boxes(masks: BoolArray) -> Float64Array:
    """Left, top, right and bottom edge of each of N masks (N, H, W), as (N, 4), the latter two behind the last pixel;
    zeros for an empty mask."""
    boxes = np.zeros((len(masks), 4))
    for box, mask in zip(boxes, masks, strict=True):
        columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
        if len(rows):
            box[:] = columns[0], rows[0], columns[-1] + 1, rows[-1] + 1
    return boxes
