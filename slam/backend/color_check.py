"""Colour check of two views: where both see one surface, its colours go together.

Corners of rooms have one shape, and windows one look; that their surfaces are light and dark, red and blue in the same
places is another matter. Exposure and white balance may differ from view to view, so what is
compared is how colours vary, not what they are.
"""

from __future__ import annotations

import numpy as np

from razer.arrays import Float64Array, IndexArray
from slam.backend.reprojection import reprojected
from slam.config import FreeSpaceSettings
from slam.frontend.keyframes import View

MIN_SHARED = 50  # readings; with fewer in common there is no answer
MIN_SPREAD = 0.05  # of logarithms of colours; where they vary less, noise is what they vary by
DARK = 4.0  # grey levels of noise, so that black has a logarithm


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
    here, there = _same_surface(source, target, target_from_source, settings)
    if len(here) < MIN_SHARED:
        return 1.0
    a, b = _centred(source, here), _centred(target, there)
    if max(a.std(), b.std()) < MIN_SPREAD:
        return 1.0
    return float((a * b).sum() / np.sqrt(max(float((a**2).sum() * (b**2).sum()), 1e-12)))


def _same_surface(
    view: View, other: View, other_from_view: Float64Array, settings: FreeSpaceSettings
) -> tuple[IndexArray, IndexArray]:
    """Pixels (M,) of a view and those of the other that read the same surface."""
    here, there, z = reprojected(view, other, other_from_view)
    read = other.sparse_depth.ravel()[there]
    near = (read > 0) & (np.abs(read - z) < settings.margin_m + settings.margin_per_m * read)
    return here[near], there[near]


def _centred(view: View, pixel: IndexArray) -> Float64Array:
    logarithms = np.log(view.sparse_rgb.reshape(-1, 3)[pixel] + DARK)
    result: Float64Array = logarithms - logarithms.mean(axis=0)
    return result
