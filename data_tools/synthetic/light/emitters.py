"""What shines in a world, by day and in the evening."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from data_tools.synthetic.shapes.solids import Colour, Glow
from razer.arrays import Float32Array, Float64Array

# "even": two distant lamps that nothing hides, and as much light from all round.
Light = Literal["day", "evening", "even"]


@dataclass(frozen=True, slots=True)
class Lighting:
    """Radiance (red, green, blue) of what shines, in units of a white wall in good light; how bright it looks itself
    is another matter, since a camera cuts off what is too bright."""

    glow: dict[Glow, Colour]
    looks: dict[Glow, Colour]
    ceiling: Colour
    """Of the light under a ceiling, at its brightest."""
    outside: Colour
    """Where a ray meets nothing."""


LIGHTING: dict[Light, Lighting] = {
    "day": Lighting(
        {"sky": (5.6, 5.9, 6.3), "lamp": (0.3, 0.27, 0.22), "screen": (0.35, 0.4, 0.45)},
        {"sky": (1.02, 1.03, 1.04), "lamp": (0.95, 0.93, 0.9), "screen": (0.95, 0.95, 0.95)},
        (0.62, 0.6, 0.57),
        (0.5, 0.52, 0.55),
    ),
    "evening": Lighting(
        {"sky": (0.012, 0.016, 0.03), "lamp": (4.5, 3.5, 2.2), "screen": (0.35, 0.4, 0.45)},
        {"sky": (0.1, 0.13, 0.22), "lamp": (1.25, 1.15, 0.9), "screen": (1.05, 1.05, 1.05)},
        (1.25, 1.02, 0.74),
        (0.02, 0.02, 0.03),
    ),
}
_PANEL_M = 3.2  # between the lights of a ceiling
_HALO_M = 0.75


def ceiling_glow(points: Float64Array, low: Float64Array, high: Float64Array) -> Float32Array:
    """How brightly the light under a ceiling shines at its points (N, 3), 0..1: lights evenly spread over the rectangle
    from low to high (2,), with soft halos."""
    glow = np.zeros(len(points))
    axes = [_spread(a, b) for a, b in zip(low, high, strict=True)]
    for x in axes[0]:
        for y in axes[1]:
            glow += np.exp(-((points[:, :2] - (x, y)) ** 2).sum(axis=1) / (2 * _HALO_M**2))
    return glow.clip(0, 1).astype(np.float32)


def _spread(low: float, high: float) -> Float64Array:
    count = max(1, round((high - low) / _PANEL_M))
    return low + (np.arange(count) + 0.5) * (high - low) / count
