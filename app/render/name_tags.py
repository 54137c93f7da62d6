"""Names written on the image of a map, each where its instance is seen."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np

from razer.arrays import BoolArray, Int32Array, Uint8Array

_FONT, _SCALE, _OUTLINE_PX = cv2.FONT_HERSHEY_SIMPLEX, 0.5, 2
_MARGIN_PX = 2
_SHIFTS_LINES = (0, -1, 1)  # beside another name there may be room above or below
_MIN_RADIUS_PX = 4  # of the largest disc within what is seen of an instance


def write_names(image: Uint8Array, instances: Int32Array, names: Mapping[int, str]) -> list[int]:
    """Write names into an image in place; one that would cover an earlier one is moved by a line or left out, and
    so are those of instances of which no more than a sliver is seen.

    Args:
        image: (H, W, 3), changed.
        instances: (H, W), the instance at each pixel, 0 = none.
        names: text by instance, in the order in which they are written.

    Returns:
        The instances whose name is there.
    """
    taken = np.zeros(instances.shape, np.bool_)
    written = []
    for instance, name in names.items():
        middle, radius_px = _widest_place(instances == instance)
        if not name or radius_px < _MIN_RADIUS_PX:
            continue
        places = (_place(middle, name, lines, instances.shape) for lines in _SHIFTS_LINES)
        corner, window = next(((c, w) for c, w in places if not taken[w].any()), (None, None))
        if corner is None or window is None:
            continue
        taken[window] = True
        written.append(instance)
        _write(image, name, corner)
    return written


def _write(image: Uint8Array, text: str, corner: tuple[int, int]) -> None:
    """Dark text with a light outline; the letters of a thicker text would be wider, and not lie below it."""
    letters = np.zeros(image.shape[:2], np.uint8)
    cv2.putText(letters, text, corner, _FONT, _SCALE, 255, 1, cv2.LINE_AA)
    outline = cv2.dilate(letters, np.ones((2 * _OUTLINE_PX + 1,) * 2, np.uint8))
    for mask, color in ((outline, 255.0), (letters, 0.0)):
        share = mask[..., None] / 255.0
        image[:] = (1 - share) * image + share * color


def _widest_place(mask: BoolArray) -> tuple[tuple[int, int], float]:
    """Centre (x, y) and radius in pixels of the largest disc within a mask; the median may lie outside it."""
    padded = np.pad(mask.astype(np.uint8), 1)  # the border of the image ends the mask, too
    distance = cv2.distanceTransform(padded, cv2.DIST_L2, 3)[1:-1, 1:-1]
    row, column = np.unravel_index(distance.argmax(), distance.shape)
    return (int(column), int(row)), float(distance[row, column])


def _place(
    middle: tuple[int, int], text: str, lines: int, shape: tuple[int, ...]
) -> tuple[tuple[int, int], tuple[slice, slice]]:
    """Lower left corner (x, y) of a text so many lines below a pixel, inside an image (H, W), and the pixels it
    covers."""
    (width, height), below = cv2.getTextSize(text, _FONT, _SCALE, 1)
    left = int(np.clip(middle[0] - width // 2, _MARGIN_PX, max(shape[1] - width, _MARGIN_PX)))
    row = middle[1] + height // 2 + lines * (height + below + _MARGIN_PX)
    bottom = int(np.clip(row, height + _MARGIN_PX, max(shape[0] - below, height + _MARGIN_PX)))
    top = bottom - height - _MARGIN_PX
    return (left, bottom), (slice(max(top, 0), bottom + below), slice(left, left + width + _MARGIN_PX))
