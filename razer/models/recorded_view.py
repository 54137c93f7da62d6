"""Views as recorded for models that look at colour alone. Colour that was brought onto depth is cropped to what depth
sees, and torn where a thing hides what is behind it from the colour camera: detectors find half as much in it."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from razer.arrays import Float32Array
from razer.frame import Frame, Intrinsics, Masks, RecordedColor
from razer.models import Embedder, Segmenter


def masks_of(segmenter: Segmenter, frame: Frame) -> Masks:
    """A segmenter's masks of a frame, on the grid of its depth. One that `looks_at_color_alone` is shown the picture as
    it was recorded, where there is another."""
    recorded = frame.recorded_color
    if recorded is None or not getattr(segmenter, "looks_at_color_alone", False):
        return segmenter.segment(frame)
    return _onto_depth(recorded, segmenter.segment(_view(recorded, frame)))


def vectors_of(embedder: Embedder, frame: Frame, masks: Masks) -> Float32Array:
    """An embedder's vectors (N, D) of masks on the grid of depth, likewise."""
    recorded = frame.recorded_color
    if recorded is None or not getattr(embedder, "looks_at_color_alone", False):
        return embedder.embed(frame, masks)
    return embedder.embed(_view(recorded, frame), _from_depth(recorded, masks))


def _view(recorded: RecordedColor, frame: Frame) -> Frame:
    """The picture as a frame without depth; its camera is made up."""
    height, width = recorded.rgb.shape[:2]
    camera = Intrinsics(width, height, float(width), float(width), width / 2, height / 2)
    return Frame(frame.index, frame.stamp, recorded.rgb, np.zeros((height, width), np.float32), camera)


def _onto_depth(recorded: RecordedColor, masks: Masks) -> Masks:
    """Masks (N, h, w) of the picture on the grid of depth, (N, H, W), but for those that nothing is left of."""
    flat = masks.masks.reshape(len(masks), -1) if len(masks) else np.zeros((0, recorded.rgb[..., 0].size), np.bool_)
    looked_up = replace(masks, masks=flat[:, recorded.pixel.ravel()].reshape(-1, *recorded.pixel.shape))
    return looked_up.select(np.flatnonzero(looked_up.masks.any(axis=(1, 2))))


def _from_depth(recorded: RecordedColor, masks: Masks) -> Masks:
    """Masks (N, H, W) on the grid of depth in the picture, (N, h, w); gaps between the places of pixels are closed."""
    size, grid = recorded.rgb.shape[:2], recorded.pixel.shape
    reach = int(np.ceil(max(size[0] / grid[0], size[1] / grid[1])))
    kernel = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    painted = np.zeros((len(masks), *size), np.uint8)
    for image, mask in zip(painted, masks.masks, strict=True):
        image.reshape(-1)[recorded.pixel[mask]] = 1
        image[:] = cv2.morphologyEx(image, cv2.MORPH_CLOSE, kernel)
    return replace(masks, masks=painted > 0)
