"""Placement of names on a picture: on what they name where it is large enough, else beside it with a leader line; none
covers another."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from razer.arrays import Int32Array

Box = tuple[int, int, int, int]
MAX_LABELS = 15
_LEAST_RADIUS_PX = 4.0  # of the largest disc within what is seen of an instance
_INSIDE_AREAS = 5.0  # an instance of so many times the label's area carries it without a line
_DIRECTIONS = 20
_DISTANCES = (1.3, 1.9, 2.6, 3.5, 4.8, 6.5, 8.5)  # of the label's middle, in its heights, beyond half its size
_GAP = 0.22  # free space around a label, in its heights
_COVERING_COST = 6.0  # of a label wholly on other things, in heights of distance
_SURFACE_COST = 2.0  # of one on surfaces beside the bare ground


@dataclass(frozen=True)
class PlacedLabel:
    """The name of an instance in a box (left, top, right, bottom) of pixels; anchor: the pixel that a line leads to,
    None where the name stands on its instance."""

    instance: int
    text: str
    box: Box
    anchor: tuple[int, int] | None


def place_labels(
    instances: Int32Array,
    names: Mapping[int, str],
    size_of: Callable[[str], tuple[int, int]],
    taken: Sequence[Box] = (),
) -> list[PlacedLabel]:
    """Where the names of instances go, at most MAX_LABELS of them.

    Args:
        instances: (H, W), the instance at each pixel, 0 = none, negative = bare ground.
        names: text by instance, the most important first; those that find no place are left out.
        size_of: width and height of a label with a text, pixels.
        taken: what must stay free of names.
    """
    layout = _Layout(instances, frozenset(names), taken)
    for number, text in names.items():
        if len(layout.placed) == MAX_LABELS:
            break
        spot = widest_place(instances, number)
        if text and spot is not None and spot[1] >= _LEAST_RADIUS_PX:
            layout.add(number, text, spot, size_of(text))
    return layout.placed


def widest_place(instances: Int32Array, number: int) -> tuple[tuple[int, int], float, int] | None:
    """Centre (x, y) and radius in pixels of the largest disc within what is seen of an instance, and its pixels."""
    mask = (instances == number).astype(np.uint8)
    left, top, width, height = cv2.boundingRect(mask)
    if width == 0:
        return None
    padded = np.pad(mask[top : top + height, left : left + width], 1)  # the border of the image ends the mask, too
    distance = cv2.distanceTransform(padded, cv2.DIST_L2, 3)[1:-1, 1:-1]
    row, column = np.unravel_index(distance.argmax(), distance.shape)
    return (left + int(column), top + int(row)), float(distance[row, column]), int(padded.sum())


class _Layout:
    """Labels placed so far, the most important first."""

    def __init__(self, instances: Int32Array, named: frozenset[int], taken: Sequence[Box]) -> None:
        self.placed: list[PlacedLabel] = []
        self._instances = instances
        self._is_thing = np.isin(instances, list(named))
        self._marks: list[tuple[int, int]] = []
        self._taken = taken

    def add(self, number: int, text: str, spot: tuple[tuple[int, int], float, int], size: tuple[int, int]) -> None:
        """Place one more, if there is room."""
        (x, y), radius, n_pixels = spot
        inside = self._box((x, y), size)
        fits = radius > 0.7 * size[1] and n_pixels > _INSIDE_AREAS * size[0] * size[1]
        if fits and inside is not None and self._is_free(inside, None):
            self._keep(PlacedLabel(number, text, inside, None), (x, y))
            return
        best = None
        for middle, steps in _around((x, y), size):
            box = self._box(middle, size)
            if box is None or not self._is_free(box, (x, y)):
                continue
            cost = steps + self._covering(box, number)
            if best is None or cost < best[0]:
                best = cost, box
        if best is not None:
            self._keep(PlacedLabel(number, text, best[1], (x, y)), (x, y))

    def _keep(self, label: PlacedLabel, mark: tuple[int, int]) -> None:
        self.placed.append(label)
        self._marks.append(mark)

    def _box(self, middle: tuple[int, int], size: tuple[int, int]) -> Box | None:
        """The box around a middle; None where it leaves the picture."""
        left, top = middle[0] - size[0] // 2, middle[1] - size[1] // 2
        height, width = self._instances.shape
        inside = left >= 1 and top >= 1 and left + size[0] < width and top + size[1] < height
        return (left, top, left + size[0], top + size[1]) if inside else None

    def _is_free(self, box: Box, anchor: tuple[int, int] | None) -> bool:
        """Whether a label there covers no other, nor the line or mark of one, nor has its own line under another."""
        gap = round(_GAP * (box[3] - box[1]))
        wide = (box[0] - gap, box[1] - gap, box[2] + gap, box[3] + gap)
        if any(_overlap(wide, box) for box in self._taken):
            return False
        for other, mark in zip(self.placed, self._marks, strict=True):
            if _overlap(wide, other.box) or _contains(wide, mark):
                return False
            if other.anchor is not None and _crosses(wide, other.anchor, middle_of(other.box)):
                return False
            if anchor is not None and _crosses(other.box, anchor, middle_of(box)):
                return False
            if anchor is not None and other.anchor is not None:
                lines = (anchor, middle_of(box)), (other.anchor, middle_of(other.box))
                if _segments_cross(*lines):
                    return False
        return True

    def _covering(self, box: Box, number: int) -> float:
        """What it costs to cover what is there: things that are named the most, the instance itself the least."""
        left, top, right, bottom = box
        seen = self._instances[top:bottom, left:right]
        things = (self._is_thing[top:bottom, left:right] & (seen != number)).mean()
        return _COVERING_COST * float(things) + _SURFACE_COST * float((seen >= 0).mean())


def _around(middle: tuple[int, int], size: tuple[int, int]) -> list[tuple[tuple[int, int], float]]:
    """Middles of labels around a place, and how far each is, in heights."""
    found = []
    for distance in _DISTANCES:
        for turn in np.arange(_DIRECTIONS) * 2 * np.pi / _DIRECTIONS:
            x = middle[0] + np.cos(turn) * (distance * size[1] + size[0] / 2)
            y = middle[1] - np.sin(turn) * (distance + 0.5) * size[1]
            found.append(((round(x), round(y)), distance))
    return found


def middle_of(box: Box) -> tuple[int, int]:
    """The middle of a box."""
    return (box[0] + box[2]) // 2, (box[1] + box[3]) // 2


def _overlap(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _contains(box: Box, point: tuple[int, int]) -> bool:
    return box[0] <= point[0] <= box[2] and box[1] <= point[1] <= box[3]


def _crosses(box: Box, start: tuple[int, int], end: tuple[int, int]) -> bool:
    """Whether a line runs through a box."""
    size = (box[2] - box[0], box[3] - box[1])
    return bool(cv2.clipLine((box[0], box[1], *size), start, end)[0])


def _segments_cross(a: tuple[tuple[int, int], ...], b: tuple[tuple[int, int], ...]) -> bool:
    def side(line: tuple[tuple[int, int], ...], point: tuple[int, int]) -> float:
        (x0, y0), (x1, y1) = line
        return float((x1 - x0) * (point[1] - y0) - (y1 - y0) * (point[0] - x0))

    return side(a, b[0]) * side(a, b[1]) < 0 and side(b, a[0]) * side(b, a[1]) < 0
