"""A hand-held camera that walks from station to station and looks where it is told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from data_tools.worlds.camera_path import TREMBLE_DEG, TREMBLE_M, looking, tremble
from data_tools.worlds.solids import Point

FRAMES_PER_S = 15.0
SPEED_M_PER_S = 0.6
TURN_DEG_PER_S = 50.0


@dataclass(frozen=True, slots=True)
class Station:
    """Where the camera is and what it looks at, metres, z up."""

    eye: Point
    target: Point


def usual_frames(stations: Sequence[Station]) -> int:
    """Frames of a walk that never exceeds SPEED_M_PER_S and TURN_DEG_PER_S by more than its smoothness asks for."""
    return int(np.ceil(_times(stations)[-1] * FRAMES_PER_S)) + 1


def walk(stations: Sequence[Station], n_frames: int, seed: int) -> NDArray[np.float64]:
    """Poses world_from_camera (n_frames, 4, 4) through all stations in order; fewer frames mean a faster walk."""
    knots = _times(stations)
    when = np.linspace(0, knots[-1], n_frames)
    heading, pitch = _directions(stations)
    along = PchipInterpolator(knots, np.column_stack([_eyes(stations), heading, pitch]))(when)
    shake = tremble(n_frames, seed)
    return np.stack(
        [
            looking(row[:3] + TREMBLE_M * w[:3], row[3] + np.radians(TREMBLE_DEG) * w[3], row[4], w[4:])
            for row, w in zip(along, shake, strict=True)
        ]
    )


def _eyes(stations: Sequence[Station]) -> NDArray[np.float64]:
    return np.array([station.eye for station in stations], float)


def _directions(stations: Sequence[Station]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Heading about z, without jumps, and pitch, both (S,) in radians."""
    x, y, z = (np.array([station.target for station in stations]) - _eyes(stations)).T
    return np.unwrap(np.arctan2(y, x)), np.arctan2(z, np.hypot(x, y))


def _times(stations: Sequence[Station]) -> NDArray[np.float64]:
    """When each station is reached, (S,) seconds."""
    heading, pitch = _directions(stations)
    way_s = np.linalg.norm(np.diff(_eyes(stations), axis=0), axis=1) / SPEED_M_PER_S
    turn_s = np.degrees(np.hypot(np.diff(heading), np.diff(pitch))) / TURN_DEG_PER_S
    return np.concatenate([[0.0], np.cumsum(np.maximum(way_s, turn_s).clip(0.2))])
