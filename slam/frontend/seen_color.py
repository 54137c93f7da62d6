"""Seen colour: the grey image of a frame whose colour camera stands beside its depth camera, and does not see all that
depth shows. What it does not see is black, and its outline is no texture: it moves as the camera does."""

from __future__ import annotations

import cv2
import numpy as np

from razer.arrays import BoolArray, Uint8Array
from razer.frame import Frame

BESIDE_PX = 8  # so near to what is not seen corners are its outline's: as far as FAST looks at ORB's middle octaves


def seen_gray(frame: Frame) -> tuple[Uint8Array, Uint8Array | None]:
    """The grey image (H, W) of a frame, in which a pixel that the colour camera does not see is as grey as the nearest
    that it sees; and where (H, W) corners may lie, not 0, None = everywhere."""
    gray = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY).astype(np.uint8, copy=False)
    if frame.has_color is None or frame.has_color.all():
        return gray, None
    if not frame.has_color.any():
        return gray, np.zeros_like(gray)
    away = cv2.distanceTransform(frame.has_color.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5)
    return _filled(gray, frame.has_color), (away > BESIDE_PX).astype(np.uint8)


def _filled(gray: Uint8Array, seen: BoolArray) -> Uint8Array:
    """An image whose pixels (H, W) that are not seen are as grey as the nearest one that is."""
    _, label = cv2.distanceTransformWithLabels(
        (~seen).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    gray_of = np.zeros(int(label.max()) + 1, np.uint8)
    gray_of[label[seen]] = gray[seen]
    return gray_of[label]
