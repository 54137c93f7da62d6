"""Names drawn on a picture: dark text on white pills with a dot in the instance's colour, and thin leader lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from app.pictures.label_layout import Box, PlacedLabel, middle_of
from razer.arrays import Uint8Array

Color = tuple[int, int, int]
_INK, _LINE, _RIM, _WHITE = (38, 42, 48), (70, 75, 82), (196, 200, 206), (255, 255, 255)
_TEXT_PER_SIDE = 0.0125  # of the picture's mean side
_LEAST_TEXT_PX = 13
_WEIGHT = 450
_FINE = 4  # bits of sub-pixel places
_OPACITY = 0.94


class LabelPen:
    """Draws labels at the scale of a picture; `text_px` is the height of its letters' line."""

    def __init__(self, size: tuple[int, int]) -> None:
        self.text_px = max(_LEAST_TEXT_PX, round(_TEXT_PER_SIDE * (size[0] + size[1]) / 2))
        self._font = cv2.FontFace("sans")

    def size_of(self, text: str) -> tuple[int, int]:
        """Width and height of a label, pixels."""
        height = round(1.65 * self.text_px)
        return round(self._text_width(text) + 1.35 * height), height

    def draw(self, image: Uint8Array, labels: Sequence[PlacedLabel], colors: Mapping[int, Color]) -> None:
        """Draw labels into an image (H, W, 3 or 4), RGB with opacity or without, in place."""
        for label in labels:
            if label.anchor is not None:
                self._leader(image, label.anchor, middle_of(label.box), colors[label.instance])
        for label in labels:
            self._pill(image, label.box, label.text, colors[label.instance])

    def draw_legend(self, image: Uint8Array, entries: Sequence[tuple[str, Color]]) -> list[Box]:
        """Draw what colours mean, one below the other at the lower left; returns the boxes taken."""
        boxes: list[Box] = []
        gap = self.text_px // 2
        bottom = image.shape[0] - gap
        for text, color in reversed(entries):
            width, height = self.size_of(text)
            if bottom - height < 0 or gap + width >= image.shape[1]:
                break
            boxes.append((gap, bottom - height, gap + width, bottom - 1))
            self._pill(image, boxes[-1], text, color)
            bottom -= height + gap
        return boxes

    def _text_width(self, text: str) -> int:
        return int(cv2.getTextSize((1, 1), text, (0, 0), self._font, self.text_px, _WEIGHT)[2])

    def _leader(self, image: Uint8Array, start: tuple[int, int], end: tuple[int, int], color: Color) -> None:
        width = max(1, round(self.text_px / 14))
        mask = np.zeros(image.shape[:2], np.uint8)
        cv2.line(mask, start, end, 255, width + 2, cv2.LINE_AA)
        _paint(image, mask, _WHITE, 0.75)
        mask[:] = 0
        cv2.line(mask, start, end, 255, width, cv2.LINE_AA)
        _paint(image, mask, _LINE, 1.0)
        for radius, ink in ((0.30, _WHITE), (0.20, color)):
            mask[:] = 0
            cv2.circle(mask, start, max(2, round(radius * self.text_px)), 255, -1, cv2.LINE_AA)
            _paint(image, mask, ink, 1.0)

    def _pill(self, image: Uint8Array, box: Box, text: str, color: Color) -> None:
        left, top, right, bottom = box
        part = image[top : bottom + 1, left : right + 1]
        height = bottom - top
        for inset, ink, opacity in ((0.0, _RIM, 0.9), (1.0, _WHITE, _OPACITY)):
            _paint(part, _pill_mask(part.shape[:2], inset), ink, opacity)
        dot = np.zeros(part.shape[:2], np.uint8)
        cv2.circle(dot, (round(0.62 * height), height // 2), round(0.21 * height), 255, -1, cv2.LINE_AA)
        _paint(part, dot, color, 1.0)
        written = np.zeros((*part.shape[:2], 3), np.uint8)
        place = (round(0.98 * height), round(0.5 * height + 0.345 * self.text_px))
        cv2.putText(written, text, place, (255, 255, 255), self._font, self.text_px, _WEIGHT)
        _paint(part, written[..., 0], _INK, 1.0)


def _pill_mask(shape: tuple[int, ...], inset: float) -> Uint8Array:
    """A rectangle with round ends (H, W), 255 inside, antialiased."""
    mask = np.zeros(shape, np.uint8)
    height, width = shape[0] - 1, shape[1] - 1
    radius = height / 2 - inset
    unit = 1 << _FINE
    for x in (height / 2, width - height / 2):
        cv2.circle(mask, (round(x * unit), round(height / 2 * unit)), round(radius * unit), 255, -1, cv2.LINE_AA, _FINE)
    top, bottom = round(inset), round(height - inset)
    mask[top : bottom + 1, round(height / 2) : round(width - height / 2) + 1] = 255
    return mask


def _paint(image: Uint8Array, mask: Uint8Array, color: Color, opacity: float) -> None:
    """Lay a colour over an image where a mask is, in place; a transparent ground becomes as opaque as the colour."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return
    window = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    part = image[window]
    over = mask[window][..., None].astype(np.float32) * (opacity / 255)
    under = part[..., 3:].astype(np.float32) / 255 if part.shape[2] == 4 else np.ones_like(over)
    total = over + under * (1 - over)
    mixed = (over * np.array(color, np.float32) + under * (1 - over) * part[..., :3]) / np.maximum(total, 1e-6)
    part[..., :3] = np.clip(mixed + 0.5, 0, 255)
    if part.shape[2] == 4:
        part[..., 3:] = np.clip(255 * total + 0.5, 0, 255)
