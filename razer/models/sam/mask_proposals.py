"""Automatic mask generation (Kirillov et al. 2023): a grid of point prompts, then filters and suppression."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from razer.arrays import BoolArray, Float32Array, Float64Array, Uint8Array
from razer.errors import BadInput
from razer.models.mask_filters import best_of_overlapping, stability
from razer.models.sam.promptable import Promptable

_OVERLAP_RASTER = 128  # columns on which overlaps are measured, about: enough for a threshold, and four times as fast


@dataclass(frozen=True)
class ProposalLimits:
    """Which mask proposals are made and kept.

    Args:
        points: prompts along the longer side of the image, each giving up to three masks. More: smaller objects, and
            time grows with the square.
        min_quality: lowest IoU that the model predicts for a mask, in [0, 1].
        min_stability: lowest stability against the threshold, in [0, 1]. Lower: more masks, with worse borders.
        most_iou: overlap above which the worse of two masks is dropped. Higher: one object has several masks.

    Raises:
        BadInput: for impossible values.
    """

    points: int = 16
    min_quality: float = 0.8
    min_stability: float = 0.9
    most_iou: float = 0.7

    def __post_init__(self) -> None:
        shares = (self.min_quality, self.min_stability, self.most_iou)
        if self.points < 1 or not all(0 <= share <= 1 for share in shares):
            raise BadInput("segmenter options: points is at least 1, and quality, stability and IoU are from 0 to 1")


def automatic_masks(model: Promptable, rgb: Uint8Array, limits: ProposalLimits) -> tuple[BoolArray, Float32Array]:
    """Masks (N, H, W) of an image (H, W, 3), best first, which may overlap, and the predicted IoU of each."""
    features, layout = model.encode(rgb)
    height, width = rgb.shape[:2]
    parts: list[tuple[Float32Array, ...]] = []
    for proposals, scores in model.at_points(features, layout, point_grid(height, width, limits.points)):
        is_good = scores >= limits.min_quality
        candidates, quality, steadiness = proposals[is_good], scores[is_good], stability(proposals[is_good])
        is_stable = steadiness >= limits.min_stability
        parts.append((candidates[is_stable], quality[is_stable], steadiness[is_stable]))
    logits, quality, steadiness = (np.concatenate(column) for column in zip(*parts, strict=True))
    step = max(1, logits.shape[-1] // _OVERLAP_RASTER)
    order = best_of_overlapping(logits[:, ::step, ::step] > 0, quality * steadiness, limits.most_iou)
    return masks_at_size(logits[order], height, width), quality[order].clip(0, 1)


def masks_in_boxes(model: Promptable, rgb: Uint8Array, boxes: Float64Array) -> BoolArray:
    """The best mask (N, H, W) for each of N boxes (N, 4) of an image (H, W, 3)."""
    height, width = rgb.shape[:2]
    if not len(boxes):
        return np.zeros((0, height, width), bool)
    features, layout = model.encode(rgb)
    best = [
        logits[np.arange(len(logits)), scores.argmax(axis=1)]
        for logits, scores in model.in_boxes(features, layout, boxes)
    ]
    return masks_at_size(np.concatenate(best), height, width)


def point_grid(height: int, width: int, n: int) -> Float64Array:
    """Centres (N, 2), x before y, of about square cells, n of them along the longer side of an image."""
    size = max(height, width) / n
    columns, rows = max(1, round(width / size)), max(1, round(height / size))
    x, y = (np.arange(columns) + 0.5) * width / columns, (np.arange(rows) + 0.5) * height / rows
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def masks_at_size(logits: Float32Array, height: int, width: int) -> BoolArray:
    """Masks (N, height, width) of logits (N, h, w) over the same image."""
    masks = np.empty((len(logits), height, width), bool)
    for mask, each in zip(masks, logits, strict=True):
        mask[:] = cv2.resize(each, (width, height), interpolation=cv2.INTER_LINEAR) > 0
    return masks
