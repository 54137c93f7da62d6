"""Hand-held camera motion: a walk round a room with jitter, looking across it, then round about, and back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from razer.arrays import Float64Array

JITTER_M = 0.012
JITTER_DEG = 0.6


def walk_round(n_frames: int, radii_m: tuple[float, float], seed: int, *, look_out: bool = True) -> Float64Array:
    """Poses world_from_camera (n_frames, 4, 4), z up, on ellipses about the origin: one turn looking across the middle,
    one near the middle looking at the walls, and back to the start.

    Args:
        n_frames: how many poses.
        radii_m: of the ellipses in x and y, metres.
        seed: of the jitter of the hand.
        look_out: False = the first turn twice, and never at the walls.
    """
    s = np.arange(n_frames) / n_frames
    heading = 4 * np.pi * s + 0.6
    # From the outside to near the middle and back; the heading never jumps.
    inward = look_out * (_smooth_step(s, 0.42, 0.58) - _smooth_step(s, 0.9, 1.0))
    out = 1 - 0.75 * inward
    position = np.stack(
        [
            radii_m[0] * out * np.cos(heading),
            radii_m[1] * out * np.sin(heading),
            1.5 + 0.2 * (1 - inward) * np.sin(6 * np.pi * s) + 0.1 * inward,
        ],
        axis=1,
    )
    # Looking across: down at the furniture. Near the middle: at the upper walls and steadily a strip of the ceiling,
    # since scraps of it seen now and then could not be known to be one thing.
    pitch_deg = (1 - inward) * (-24 + 9 * np.sin(8 * np.pi * s)) + inward * (5 + 3 * np.sin(14 * np.pi * s))
    pitch = np.radians(pitch_deg)
    shake = jitter(np.arange(n_frames), seed)
    return np.stack(
        [
            looking(p + JITTER_M * w[:3], h + np.pi + np.radians(JITTER_DEG) * w[3], a, w[4:])
            for p, h, a, w in zip(position, heading, pitch, shake, strict=True)
        ]
    )


def _smooth_step(s: Float64Array, start: float, end: float) -> Float64Array:
    x = np.clip((s - start) / (end - start), 0, 1)
    return x * x * (3 - 2 * x)


def jitter(frames: NDArray[np.number], seed: int) -> Float64Array:
    """Six smooth random signals of unit amplitude at frame numbers (N,), (N, 6), from sines of 7 to 25 frames."""
    rng = np.random.default_rng([seed, 2])
    periods, phases = rng.uniform(7, 25, (4, 6)), rng.uniform(0, 2 * np.pi, (4, 6))
    waves = np.sin(2 * np.pi * frames[:, None, None] / periods + phases)
    return waves.mean(axis=1) * np.sqrt(2)


def looking(position: Float64Array, heading: float, pitch: float, jitter: Float64Array) -> Float64Array:
    """The pose (4, 4) at a position that looks along a direction; camera axes x right, y down, z forward.

    Args:
        position: (3,) metres.
        heading: about z, radians.
        pitch: up positive, radians.
        jitter: (2,) extra pitch and roll, in units of JITTER_DEG.
    """
    pitch = pitch + np.radians(JITTER_DEG) * jitter[0]
    roll = np.radians(JITTER_DEG) * jitter[1]
    forward = np.array([np.cos(heading) * np.cos(pitch), np.sin(heading) * np.cos(pitch), np.sin(pitch)])
    right = np.array([np.sin(heading), -np.cos(heading), 0.0])
    down = np.cross(forward, right)
    pose = np.eye(4)
    pose[:3, 0] = np.cos(roll) * right + np.sin(roll) * down
    pose[:3, 1] = np.cos(roll) * down - np.sin(roll) * right
    pose[:3, 2] = forward
    pose[:3, 3] = position
    return pose
