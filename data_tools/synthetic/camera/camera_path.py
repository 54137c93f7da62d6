"""Camera paths through furnished rooms: along free routes, looking ahead or round about."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from data_tools.synthetic.camera.walk import Station
from data_tools.synthetic.layout.free_space import FreeSpace
from razer.arrays import Float64Array

EYE_M = 1.5
_AHEAD_M = 1.5
_AHEAD_HEIGHT_M = 1.05
_STRIDE_M = 0.15
_SWAY_M = 4.0
_STAY = 8
_HEIGHTS_M = (0.55, 1.0, 0.4, 1.45, 0.75)


class CameraPath:
    """Stations collected one route after the other, from a start (x, y)."""

    def __init__(self, space: FreeSpace, start: Sequence[float]) -> None:
        self.stations: list[Station] = []
        self._space = space
        self._walked = 0.0
        self._position = space.nearest(start)

    def go(self, to: Sequence[float], sway_deg: float = 0.0) -> None:
        """Walk to the free place nearest to a point, looking ahead and a little down, and in turn to the left and to
        the right by up to sway_deg."""
        route = self._resampled_route(self._space.nearest(to))
        for point, along in zip(route, _distances(route), strict=True):
            self._walked += _STRIDE_M
            sway = np.radians(sway_deg) * np.sin(2 * np.pi * self._walked / _SWAY_M)
            ahead = _at(route, along + _AHEAD_M)
            towards = ahead - point if np.linalg.norm(ahead - point) > 0.3 else route[-1] - _at(route, along - 0.5)
            if np.linalg.norm(towards) > 1e-6:
                cos, sin = np.cos(sway), np.sin(sway)
                turned = np.array([[cos, -sin], [sin, cos]]) @ towards / np.linalg.norm(towards)
                self._look(point, point + _AHEAD_M * turned, _AHEAD_HEIGHT_M)

    def look(self, at: Sequence[float], height_m: float = _AHEAD_HEIGHT_M) -> None:
        """Turn to a point and stay."""
        for _ in range(_STAY):
            self._look(self._position, np.asarray(at, float), height_m)

    def round(
        self, low: Sequence[float], high: Sequence[float], reach: float = 0.5, turns: float = 1.0, places: int = 8
    ) -> None:
        """Walk round the middle of a rectangle, looking across; it starts on the side where the camera is.

        Args:
            low: corner (x, y) of the rectangle, metres.
            high: the opposite corner.
            reach: share of the route from the middle to its sides, where that is free.
            turns: how many times round.
            places: free places aimed at in each turn.
        """
        center, half = np.add(low, high) / 2, np.subtract(high, low) / 2
        start = np.arctan2(*((self._position - center) / half)[::-1])
        count = round(places * turns)
        angles = start + 2 * np.pi * turns * np.arange(count + 1) / count
        for number in range(count):
            rim = np.stack([np.cos(angles), np.sin(angles)], axis=1)
            route = self._resampled_route(self._space.nearest(center + reach * half * rim[number + 1]))
            shares = _distances(route) / max(_distances(route)[-1], 1e-9)
            for point, share in zip(route, shares, strict=True):
                angle = angles[number] + share * (angles[number + 1] - angles[number])
                rise = np.interp(share, (0, 1), [_HEIGHTS_M[(number + k) % len(_HEIGHTS_M)] for k in (0, 1)])
                self._look(point, center - half * (np.cos(angle), np.sin(angle)), float(rise))

    def _resampled_route(self, to: Float64Array) -> Float64Array:
        route = self._space.route(self._position, to)
        self._position = to
        along = _distances(route)
        count = max(2, int(np.ceil(along[-1] / _STRIDE_M)) + 1)
        return np.stack([_at(route, s) for s in np.linspace(0, along[-1], count)])

    def _look(self, point: Float64Array, at: Float64Array, height_m: float) -> None:
        eye = (float(point[0]), float(point[1]), EYE_M)
        self.stations.append(Station(eye, (float(at[0]), float(at[1]), height_m)))


def _distances(route: Float64Array) -> Float64Array:
    """How far along a route (K, 2) each of its points is, (K,)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(route, axis=0), axis=1))])


def _at(route: Float64Array, along: float) -> Float64Array:
    distances = _distances(route)
    return np.array([np.interp(along, distances, route[:, k]) for k in range(2)])
