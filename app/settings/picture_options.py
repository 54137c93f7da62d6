"""Options of the verbs that draw a map."""

from __future__ import annotations

import re
from dataclasses import dataclass

from cyclopts import Parameter

from app.pictures.view import Background, View, parse_angle
from razer.errors import BadInput

_SIDES_PX = (64, 8192)


@Parameter(name="*")
@dataclass(frozen=True)
class PictureOptions:
    """How a map is shown in a picture."""

    angle: str | None = None
    """top, front, right, back, left, or AZIMUTH,ELEVATION in degrees: around the map from the front, which is square to
    the walls, and above the floor. Where most things are seen if not given."""
    size: str | None = None
    """WIDTHxHEIGHT of the picture, pixels; as large as the map within 1600x1200 if not given."""
    background: Background = "white"
    """What is behind the map."""

    def view(self) -> View:
        """What these options ask for; raises BadInput."""
        angle = None if self.angle is None else parse_angle(self.angle)
        return View(angle, self._size(), self.background)

    def _size(self) -> tuple[int, int] | None:
        if self.size is None:
            return None
        match = re.fullmatch(r"(\d{1,5})x(\d{1,5})", self.size)
        low, high = _SIDES_PX
        if match is None or not all(low <= int(side) <= high for side in match.groups()):
            raise BadInput(f"--size {self.size}: write it as 1600x1200, with sides from {low} to {high} pixels")
        return int(match[1]), int(match[2])
