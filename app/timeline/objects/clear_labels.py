"""Names that do not lie upon each other on the screen, as seen from where the viewer opens."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.render.viewpoint import Viewpoint
from razer.arrays import BoolArray, Float64Array

FIELD_OF_VIEW_DEG = 45.0  # vertical; the viewer's own
CHARACTER_PX, LINE_PX, MARGIN_PX = 7.5, 22.0, 16.0  # of the viewer's labels


def clear_labels(positions: Float64Array, texts: Sequence[str], eye: Viewpoint, height_px: float) -> list[int]:
    """Rows of labels at (N, 3) metres, the first ones first, that leave those before them readable in a view so many
    pixels high."""
    focal_px = height_px / 2 / np.tan(np.radians(FIELD_OF_VIEW_DEG / 2))
    places, visible = _on_screen(positions, eye, focal_px)
    half_sizes = np.array([[(CHARACTER_PX * len(text) + MARGIN_PX) / 2, LINE_PX / 2] for text in texts])
    kept: list[int] = []
    for row in np.flatnonzero(visible).tolist():
        apart = np.abs(places[kept] - places[row]) >= half_sizes[kept] + half_sizes[row]
        if apart.any(axis=1).all():
            kept.append(row)
    return kept


def _on_screen(positions: Float64Array, eye: Viewpoint, focal_px: float) -> tuple[Float64Array, BoolArray]:
    """Where points (N, 3) are seen from an eye, (N, 2) pixels from the middle of the screen, and whether they lie in
    front of it (N,)."""
    forward = (eye.target - eye.position) / np.linalg.norm(eye.target - eye.position)
    right = np.cross(forward, eye.up)
    right /= np.linalg.norm(right)
    seen = (positions - eye.position) @ np.stack([right, np.cross(forward, right), forward], axis=1)
    in_front = seen[:, 2] > 1e-3
    return focal_px * seen[:, :2] / np.where(in_front, seen[:, 2], 1.0)[:, None], in_front
