"""Trajectory of a hand-held camera from station to station, each with its point to look at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from data_tools.synthetic.camera.hand_held import JITTER_DEG, JITTER_M, jitter, looking
from data_tools.synthetic.shapes.solids import Point
from razer.arrays import Float64Array

FRAMES_PER_S = 15.0
# Of the walk itself; the hand adds a little, and the sum stays below 0.5 m/s and 60 degrees/s.
SPEED_M_PER_S = 0.45
TURN_DEG_PER_S = 54.0
_JITTER_SHARE = 0.4
_SMOOTH_S = 0.35
_STEP_S = 1 / 30
_EASE_STATIONS = 3.0
_PITCH_DEG = (-40.0, 10.0)


@dataclass(frozen=True, slots=True)
class Station:
    """Where the camera is and what it looks at, metres, z up."""

    eye: Point
    target: Point


def usual_frames(stations: Sequence[Station]) -> int:
    """Frames at FRAMES_PER_S of a walk at SPEED_M_PER_S and TURN_DEG_PER_S, or slower."""
    return int(np.ceil(_times(stations)[-1] * FRAMES_PER_S)) + 1


def walk(stations: Sequence[Station], n_frames: int, seed: int, *, earlier_s: float = 0.0) -> Float64Array:
    """Poses world_from_camera (n_frames, 4, 4) from the first station to the last, past those between with rounded
    corners; fewer frames lie further apart. Pitch stays within -40 and 10 degrees.

    Args:
        stations: where the camera is in turn, and what it looks at.
        n_frames: how many poses.
        seed: of the hand that holds the camera.
        earlier_s: where the camera was so many seconds before each frame; before the first it stood still.
    """
    knots = _times(stations)
    when = np.maximum(np.linspace(0, knots[-1], n_frames) - earlier_s, 0)
    dense = np.linspace(0, knots[-1], int(np.ceil(knots[-1] / _STEP_S)) + 1)
    signals = [np.interp(dense, knots, column) for column in (*_eyes(stations).T, *_directions(stations))]
    smooth = [gaussian_filter1d(signal, _SMOOTH_S / _STEP_S, mode="nearest") for signal in signals]
    rows = np.column_stack([np.interp(when, dense, signal) for signal in smooth])
    shake = _JITTER_SHARE * jitter(when * FRAMES_PER_S, seed)
    return np.stack(
        [
            looking(row[:3] + JITTER_M * w[:3], row[3] + np.radians(JITTER_DEG) * w[3], row[4], w[4:])
            for row, w in zip(rows, shake, strict=True)
        ]
    )


def _eyes(stations: Sequence[Station]) -> Float64Array:
    return np.array([station.eye for station in stations], float)


def _directions(stations: Sequence[Station]) -> tuple[Float64Array, Float64Array]:
    """Heading about z, without jumps, and pitch, both (S,) in radians, eased over the neighbouring stations, so that
    one turns while one walks."""
    x, y, z = (np.array([station.target for station in stations]) - _eyes(stations)).T
    pitch = np.arctan2(z, np.hypot(x, y)).clip(*np.radians(_PITCH_DEG))
    heading, pitch = gaussian_filter1d([np.unwrap(np.arctan2(y, x)), pitch], _EASE_STATIONS, mode="nearest")
    return heading, pitch


def _times(stations: Sequence[Station]) -> Float64Array:
    """When each station is reached, (S,) seconds."""
    heading, pitch = _directions(stations)
    way_s = np.linalg.norm(np.diff(_eyes(stations), axis=0), axis=1) / SPEED_M_PER_S
    turn_s = np.degrees(np.hypot(np.diff(heading), np.diff(pitch))) / TURN_DEG_PER_S
    return np.concatenate([[0.0], np.cumsum(np.maximum(way_s, turn_s).clip(1e-3))])
