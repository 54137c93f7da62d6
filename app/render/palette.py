"""Colours of instances, classes and scores: calm, told apart with any colour vision, the same in pictures, timeline and
page (app/page/viewer/src/state/palette.ts has the same tables)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from razer.arrays import IntArray, Uint8Array

# Tol's "muted" hues, softened.
HUES = np.array(
    [
        [86, 140, 193], [222, 142, 79], [92, 165, 138], [190, 104, 137], [214, 186, 98],
        [125, 113, 178], [143, 190, 218], [166, 90, 74], [134, 164, 84], [200, 158, 190],
    ], np.uint8
)  # fmt: skip
# Surfaces that are not counted stay pale, so that things stand out of them.
STUFF = np.array([[201, 197, 189], [184, 190, 198], [211, 203, 186], [190, 197, 188], [205, 195, 200]], np.uint8)
NOBODY = (176, 178, 182)
SHADES = (1.0, 0.8, 1.35)  # of the hues, when all of them are taken: below 1 darker, above lighter
# By id neighbours are often seen together: an order in which three in a row are far apart, and more shades.
_BY_ID = HUES[[0, 3, 1, 6, 2, 5, 4, 7, 8, 9]]
_MORE_SHADES = (1.0, 0.75, 1.35, 0.87, 1.16)
_STUFF_CLASS_SHARE, _STUFF_CLASS_GREY = 0.42, 205


def instance_colors(ids: IntArray) -> Uint8Array:
    """Colours (N, 3) of instance ids (N,): neighbouring ids get unlike hues, 0 (no instance) is grey."""
    ids = np.asarray(ids, np.int64)
    return np.where(ids[:, None] > 0, _nth(_BY_ID, np.maximum(ids - 1, 0), _MORE_SHADES), NOBODY).astype(np.uint8)


def colors_by_place(places: IntArray, is_stuff: bool) -> Uint8Array:
    """Colours (N, 3) of instances by their places (N,) among the things, or the stuff, of a map, the largest first."""
    return _nth(STUFF if is_stuff else HUES, places, SHADES)


def class_colors(places: IntArray, is_stuff: bool) -> Uint8Array:
    """Colours (N, 3) of classes by their places (N,) among those of a map; stuff has the same hues, paler."""
    colors = _nth(HUES, places, SHADES)
    if not is_stuff:
        return colors
    return _rounded(_STUFF_CLASS_SHARE * colors + (1 - _STUFF_CLASS_SHARE) * _STUFF_CLASS_GREY)


def _nth(colors: Uint8Array, places: IntArray, shades: Sequence[float]) -> Uint8Array:
    """Neighbouring places get unlike hues; every round through them another shade."""
    places = np.asarray(places, np.int64)
    factor = np.array(shades)[places // len(colors) % len(shades)][:, None]
    chosen = colors[places % len(colors)].astype(np.float64)
    return _rounded(np.where(factor > 1, 255 - (255 - chosen) / factor, chosen * factor))


def _rounded(colors: np.ndarray) -> Uint8Array:
    """Half upwards, as in the page."""
    return np.floor(colors + 0.5).astype(np.uint8)
