"""Colour check of two views: where both see one surface, its colours go together.

Corners of rooms have one shape, and windows one look; that their surfaces are light and dark, red and blue in the same
places is another matter. Exposure, white balance and contrast may differ from view to view, so what is
compared is how colours vary, not what they are.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np

from razer.arrays import Float32Array, Float64Array, FloatArray, IndexArray, Uint8Array
from razer.geometry import inverse
from slam.backend.view_checks.reprojection import KEPT_VIEWS, flat_depth, reprojected, smear_pixels
from slam.config import FreeSpaceSettings
from slam.frontend.keyframes import View
from slam.frontend.sparse_readings import SparseReadings

MIN_SHARED = 50  # readings; with fewer in common there is no answer
MIN_SPREAD = 0.05  # of logarithms of colours; where they vary less, noise is what they vary by
DARK = 4.0  # grey levels of noise, so that black has a logarithm
LOGARITHMS = np.log(np.arange(256, dtype=np.float32) + np.float32(DARK))
OVEREXPOSED = 250  # grey levels from which a surface may be any brighter
BRIGHTEST = np.where(np.arange(256) < OVEREXPOSED, LOGARITHMS, np.float32(np.inf))
# By which the logarithms of a colour differ where something else is seen: times what most readings of both views differ
# by, as exposure, vignetting and reflections bring; a tenth at least, as of seats of chairs that are otherwise alike; a
# third is always enough. It fills a patch: edges that lie a pixel off are lines.
TIMES_USUAL, LEAST_OTHER, SURELY_OTHER = 3.0, 0.1, 0.3
PATCH = 2  # pixels, so many by so many
# How logarithms of one view's colours become another's, channel by channel: a line, as under a camera's tone curve
# exposure does not shift them alone. It is fitted to some of the readings, none far off counting much (Cauchy), and its
# slope stays near 1 where colours vary by less than a spread. Its logarithm is as much as that of the factor by which
# colours became lighter or darker, at the most: exposure that stayed bends nothing, and what looks as if it did is
# another colour.
EACH, TONE_ROUNDS, TONE_SIGMA, TONE_SPREAD = 4, 3, 0.1, 0.14
MOST_SLOPE = 1.6
HUES = 0.85  # of the cases: fewer say less of things that are few, more are edges and noise
WIDEST = 4  # pixels of the nearer view about one that are looked at, as many as a pixel of the other spans


def color_correlation(
    target: View, source: View, target_from_source: Float64Array, settings: FreeSpaceSettings
) -> float:
    """Pearson correlation of the logarithmic colours of the readings that both views have of one surface, each view's
    less their mean; 1 where there is no answer.

    Args:
        target: one view.
        source: the other.
        target_from_source: (4, 4) the motion to be checked.
        settings: how far apart readings of one surface may lie.
    """
    here, there, _ = _same_surface(source, target, target_from_source, settings)
    if len(here) < MIN_SHARED:
        return 1.0
    a, b = _centred(source, here), _centred(target, there)
    if max(a.std(), b.std()) < MIN_SPREAD:
        return 1.0
    return float((a * b).sum() / np.sqrt(max(float((a**2).sum() * (b**2).sum()), 1e-12)))


class ColorDifference(NamedTuple):
    """How the colours of two views of one surface differ, in logarithms.

    Attributes:
        share: of the readings that have other colours.
        n_readings: how many readings there are.
        light_change: what the quarter of them that differs least differs by at the most: other light changes these,
            too, other things do not.
        hue_change: what a channel differs by more than all three do, in 85 of 100 cases: other things change that, too,
            other light hardly.
    """

    share: float
    n_readings: int
    light_change: float = 0.0
    hue_change: float = 0.0


def color_difference(
    target: View, source: View, target_from_source: Float64Array, settings: FreeSpaceSettings
) -> ColorDifference | None:
    """Share of the readings that both views have of one surface whose colour is none that the other view has round
    about, whatever the exposure, contrast and white balance; the greater of both ways, None where they share too few. A
    view from farther away blurs what the nearer one tells apart, so that pixels of this one stand for those next to
    them, too.

    Args:
        target: one view.
        source: the other.
        target_from_source: (4, 4) the motion to be checked.
        settings: how far apart readings of one surface may lie.
    """
    both_ways = (
        _difference(source, target, target_from_source, settings),
        _difference(target, source, inverse(target_from_source), settings),
    )
    return max((difference for difference in both_ways if difference is not None), default=None)


def other_colors(
    target: View, source: View, target_from_source: Float64Array, settings: FreeSpaceSettings
) -> float | None:
    """The share alone of `color_difference`, whose arguments are these."""
    difference = color_difference(target, source, target_from_source, settings)
    return None if difference is None else difference.share


def _difference(
    view: View, other: View, other_from_view: Float64Array, settings: FreeSpaceSettings
) -> ColorDifference | None:
    here, there, span = _same_surface(view, other, other_from_view, settings)
    if len(here) < MIN_SHARED:
        return None
    own, others = _logarithms(view, here), _logarithms(other, there)
    slope, offset = _tone(own, others)
    differences = others - slope * own - offset
    light_change, usual = _quartiles(differences)
    least_other = min(max(TIMES_USUAL * usual, LEAST_OTHER), SURELY_OTHER)
    least, greatest = _range_about(view, here, np.rint(1 / span) - 1)
    # Edges may be a pixel off, and more where cameras turned.
    darkest, brightest = _range_about(other, there, np.rint(span).clip(min=1) + smear_pixels(view, other))
    outside = np.maximum(darkest - slope * greatest - offset, slope * least + offset - brightest)
    is_other = np.maximum(np.maximum(outside[0], outside[1]), outside[2]) > least_other
    share = _n_in_patches(view, here[is_other]) / len(here)
    return ColorDifference(share, len(here), light_change, _hue_change(differences))


def _tone(own: Float32Array, others: Float32Array) -> tuple[Float32Array, Float32Array]:
    """Slope and offset (3, 1) of the lines that bring logarithms of colours (3, M) to what another view has (3, M), by
    iteratively reweighted least squares on some of them. What does not shift colours does not bend them either."""
    own, others = (np.ascontiguousarray(each[:, ::EACH]) for each in (own, others))
    slope, offset = np.ones((3, 1), np.float32), _medians(others - own)
    steepest = np.minimum(np.exp(np.abs(offset)), MOST_SLOPE)
    for _ in range(TONE_ROUNDS):
        weight = 1 / (1 + np.square((others - slope * own - offset) / TONE_SIGMA))
        weight /= weight.sum(axis=1, keepdims=True)
        own_mean, others_mean = ((weight * each).sum(axis=1, keepdims=True) for each in (own, others))
        weighted = weight * (own - own_mean)
        products, squares = ((weighted * each).sum(axis=1, keepdims=True) for each in (others, own))
        slope = ((products + TONE_SPREAD**2) / (squares + TONE_SPREAD**2)).clip(1 / steepest, steepest)
        offset = others_mean - slope * own_mean
    return slope, _medians(others - slope * own)


def _medians(a: FloatArray) -> FloatArray:
    """Of each row of a (R, N), as a column."""
    low, high = (a.shape[1] - 1) // 2, a.shape[1] // 2
    ordered = np.partition(a, (low, high), axis=1)
    result: FloatArray = (ordered[:, low : low + 1] + ordered[:, high : high + 1]) / 2
    return result


def _quartiles(differences: Float32Array) -> tuple[float, float]:
    """The lower quartile and the median of what logarithms (3, M) differ by."""
    size = differences.size
    sizes = np.partition(np.abs(differences).ravel(), (size // 4, (size - 1) // 2, size // 2))
    return float(sizes[size // 4]), float((sizes[(size - 1) // 2] + sizes[size // 2]) / np.float32(2))


def _hue_change(differences: Float32Array) -> float:
    """What a channel of differences (3, M) has more than the mean of all, in HUES of the cases; of some of them."""
    some = differences[:, ::EACH]
    sizes, rank = np.abs(some - some.mean(axis=0)).ravel(), int(HUES * some.size)
    return float(np.partition(sizes, rank)[rank])


def _n_in_patches(view: View, pixels: IndexArray) -> int:
    """How many of the pixels (M,) of a view fill patches (morphological opening)."""
    image, square = np.zeros(view.sparse.depth.shape, np.uint8), np.ones((PATCH, PATCH), np.uint8)
    image.ravel()[pixels] = 1
    return int(cv2.morphologyEx(image, cv2.MORPH_OPEN, square, borderType=cv2.BORDER_CONSTANT, borderValue=0).sum())


def _range_about(view: View, pixels: IndexArray, radii: Float32Array) -> tuple[Float32Array, Float32Array]:
    """The least and the greatest logarithms (3, M) that the colours of a view may have within radii (M,) of pixels."""
    rounded = radii.clip(0, WIDEST).astype(np.intp)
    which = rounded * view.sparse.depth.size + pixels
    least, greatest = (each.take(which, axis=0) for each in _extremes(view.sparse, int(rounded.max(initial=0))))
    return cv2.LUT(_by_channel(least), LOGARITHMS), cv2.LUT(_by_channel(greatest), BRIGHTEST)


@lru_cache(maxsize=KEPT_VIEWS)
def _extremes(readings: SparseReadings, widest: int) -> tuple[Uint8Array, Uint8Array]:
    """The least and the greatest colours (h * w, 3) within no pixel of each, within one, and so on, one after the
    other."""
    squares = [np.ones((2 * radius + 1,) * 2, np.uint8) for radius in range(widest + 1)]
    least, greatest = (
        np.concatenate([filtered(readings.rgb, square).reshape(-1, 3) for square in squares])
        for filtered in (cv2.erode, cv2.dilate)
    )
    return least, greatest


def _same_surface(
    view: View, other: View, other_from_view: Float64Array, settings: FreeSpaceSettings
) -> tuple[IndexArray, IndexArray, Float32Array]:
    """Pixels (M,) of a view and those of the other that read the colours of one surface, and how many pixels of the
    other (M,) one of the view spans there."""
    here, there, z = reprojected(view, other, other_from_view)
    read = flat_depth(other.sparse)[there]
    is_same = (read > 0) & (np.abs(read - z) < settings.margin_m + settings.margin_per_m * read)
    near = np.flatnonzero(is_same & view.sparse.has_color.ravel()[here] & other.sparse.has_color.ravel()[there])
    here, there, z = here[near], there[near], z[near]
    times_finer = other.sparse.intrinsics.fx / view.sparse.intrinsics.fx
    return here, there, times_finer * flat_depth(view.sparse)[here] / z


def _centred(view: View, pixels: IndexArray) -> Float64Array:
    logarithms = _logarithms(view, pixels).T.astype(np.float64)
    result: Float64Array = logarithms - logarithms.mean(axis=0)
    return result


def _logarithms(view: View, pixels: IndexArray) -> Float32Array:
    """Of the colours (3, M) of pixels."""
    return cv2.LUT(_by_channel(view.sparse.rgb.reshape(-1, 3).take(pixels, axis=0)), LOGARITHMS)


def _by_channel(colors: Uint8Array) -> Uint8Array:
    """Colours (M, 3) as (3, M), laid out anew: to work on whole channels takes a third of the time then."""
    return np.ascontiguousarray(colors.T)
