"""Pictures side by side, each under what it shows."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from razer.arrays import Uint8Array

_CAPTION_PX, _TEXT_PX, _WEIGHT = 54, 22, 500
_INK = (38, 42, 48)


def captioned_row(panels: Sequence[tuple[str, Uint8Array]]) -> Uint8Array:
    """RGB image (H + 54, sum of W, 3) uint8: pictures (H, W, 3) of one height in a row, their captions above."""
    return np.concatenate([np.concatenate([_caption(text, image.shape[1]), image]) for text, image in panels], axis=1)


def _caption(text: str, width: int) -> Uint8Array:
    strip = np.full((_CAPTION_PX, width, 3), 255, np.uint8)
    font = cv2.FontFace("sans")
    cv2.putText(strip, text, (round(0.6 * _TEXT_PX), _CAPTION_PX - _TEXT_PX // 2), _INK, font, _TEXT_PX, _WEIGHT)
    return strip
