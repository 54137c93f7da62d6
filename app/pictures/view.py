"""How a map is shown: style, angle, size, background."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from razer.errors import BadInput

Background = Literal["white", "transparent"]
Style = Literal["color", "instance", "class", "query"]
LARGEST = (1600, 1200)
_FRONT_ELEVATION_DEG = 20.0


@dataclass(frozen=True)
class Angle:
    """azimuth_deg: anticlockwise around the map as seen from above, 0 = the front, which is square to the walls;
    elevation_deg: 0 = level, 90 = straight down."""

    azimuth_deg: float
    elevation_deg: float

    def __str__(self) -> str:
        return f"{self.azimuth_deg:g},{self.elevation_deg:g}"


NAMED = {
    "top": Angle(0.0, 90.0),
    "front": Angle(0.0, _FRONT_ELEVATION_DEG),
    "right": Angle(90.0, _FRONT_ELEVATION_DEG),
    "back": Angle(180.0, _FRONT_ELEVATION_DEG),
    "left": Angle(270.0, _FRONT_ELEVATION_DEG),
}


def parse_angle(text: str) -> Angle:
    """A name, or AZIMUTH,ELEVATION in degrees; raises BadInput."""
    if text in NAMED:
        return NAMED[text]
    try:
        azimuth, elevation = map(float, text.split(","))
    except ValueError:
        azimuth = elevation = math.nan
    if not (math.isfinite(azimuth) and 0 <= elevation <= 90):
        raise BadInput(
            f"--angle {text}: give {', '.join(NAMED)}, or AZIMUTH,ELEVATION in degrees with an elevation from 0 to 90"
        )
    return Angle(azimuth, elevation)


@dataclass(frozen=True)
class View:
    """How it is shown. angle: None = where most is seen; size: width and height of the picture, pixels, None = as large
    as the map within LARGEST; background: white, or transparent."""

    angle: Angle | None = None
    size: tuple[int, int] | None = None
    background: Background = "white"
