"""Upper bounds of the IoU of oriented boxes from axis-aligned bounds: cheap reasons not to clip a pair exactly."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from razer.arrays import Float64Array, IndexArray
from razer.boxes.oriented_box import OrientedBox


def iou_bounds(boxes: Sequence[OrientedBox], margin_m: float, first: IndexArray, second: IndexArray) -> Float64Array:
    """Upper bounds (P,) of the IoU of pairs of boxes, which share at most what their bounds along the world's axes do.

    Args:
        boxes: N oriented boxes.
        margin_m: Added to every side of each, metres.
        first: One box (P,) of each pair.
        second: The other (P,).
    """
    center, rotation, half = _stacked(boxes, margin_m)
    reach = _reach(rotation, half)
    low, high = center - reach, center + reach
    overlap = np.minimum(high[first], high[second]) - np.maximum(low[first], low[second])
    return _max_iou(overlap, half[first], half[second])


def tight_iou_bounds(
    boxes: Sequence[OrientedBox], margin_m: float, first: IndexArray, second: IndexArray
) -> Float64Array:
    """The same from bounds along the axes of either box, which is tighter and takes longer.

    Args:
        boxes: N oriented boxes.
        margin_m: Added to every side of each, metres.
        first: One box (P,) of each pair.
        second: The other (P,).
    """
    center, rotation, half = _stacked(boxes, margin_m)
    bounds = []
    for own, others in ((first, second), (second, first)):
        axes = rotation[own].transpose(0, 2, 1)
        offset = (axes @ (center[others] - center[own])[..., None])[..., 0]
        reach = _reach(axes @ rotation[others], half[others])
        overlap = np.minimum(half[own], offset + reach) - np.maximum(-half[own], offset - reach)
        bounds.append(_max_iou(overlap, half[own], half[others]))
    return np.minimum(*bounds)


def _stacked(boxes: Sequence[OrientedBox], margin_m: float) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Centres (N, 3), rotations (N, 3, 3) and half edges (N, 3) of boxes grown by a margin."""
    center, rotation, extent = (
        np.concatenate([getattr(box, part) for box in boxes]).reshape(len(boxes), -1, 3)
        for part in ("center", "rotation", "extent")
    )
    return center[:, 0], rotation, extent[:, 0] / 2 + margin_m


def _reach(rotation: Float64Array, half: Float64Array) -> Float64Array:
    """How far boxes (P, 3) that are turned by (P, 3, 3) reach along the axes."""
    reach: Float64Array = (np.abs(rotation) @ half[..., None])[..., 0]
    return reach


def _max_iou(overlap: Float64Array, half: Float64Array, other_half: Float64Array) -> Float64Array:
    """The IoU (P,) of boxes that share no more than an overlap (P, 3), nor than the smaller one's volume."""
    volume, other_volume = (8 * h.prod(axis=1) for h in (half, other_half))
    max_shared = np.minimum(overlap.clip(min=0).prod(axis=1), np.minimum(volume, other_volume))
    iou: Float64Array = max_shared / np.maximum(volume + other_volume - max_shared, 1e-12)
    return iou
