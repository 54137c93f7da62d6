"""Placed pictures: what two pictures say of each other where they would lie, told once for each place.

Parts are grown, pictures moved, and doubts looked into, and all of these ask the same of the same pictures.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from razer.arrays import Float64Array
from slam.backend.submaps.placement_check import PlacedPair
from slam.backend.view_checks.color_check import ColorDifference
from slam.config import FreeSpaceSettings
from slam.frontend.keyframes import Keyframes

OFF_M = 0.1  # by which pictures may lie off, placed as they are by few others
SAME_TO = 3  # decimals of metres and radians: nothing is told differently so close by


@dataclass(frozen=True, eq=False)
class ComparedPair(PlacedPair):
    """A placed pair under settings that stay, so that what it tells is kept."""

    settings: FreeSpaceSettings = field(kw_only=True)

    def contradiction(self, settings: FreeSpaceSettings) -> float:
        """As the placed pair has it."""
        return self._contradiction if settings is self.settings else super().contradiction(settings)

    def color_difference(self, settings: FreeSpaceSettings) -> ColorDifference | None:
        """As the placed pair has it."""
        return self._color_difference if settings is self.settings else super().color_difference(settings)

    @cached_property
    def _contradiction(self) -> float:
        return super().contradiction(self.settings)

    @cached_property
    def _color_difference(self) -> ColorDifference | None:
        return super().color_difference(self.settings)


@dataclass(frozen=True, eq=False)
class PlacedPictures:
    """Pairs of keyframes as they would lie, by number and motion."""

    keyframes: Keyframes
    settings: FreeSpaceSettings
    _pairs: dict[tuple[int, int, bytes], ComparedPair] = field(default_factory=dict)

    def pair(self, a: int, b: int, a_from_b: Float64Array) -> PlacedPair:
        """Two keyframes at a motion (4, 4), or at one next to it that was asked for before."""
        place = (np.round(a_from_b[:3], SAME_TO) + 0.0).tobytes()
        if (a, b, place) not in self._pairs:
            views = self.keyframes[a].view, self.keyframes[b].view
            self._pairs[a, b, place] = ComparedPair(*views, a_from_b, OFF_M, settings=self.settings)
        return self._pairs[a, b, place]
