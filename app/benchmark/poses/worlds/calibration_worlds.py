"""Worlds in which covariances of poses are held against true errors: scenes of several kinds, seen by two sensors, at
several frame rates. None of them has anything that pose estimation gets wrong altogether."""

from __future__ import annotations

from functools import partial

from app.benchmark.poses.worlds.hard_worlds import KINECT, PLAIN, HardWorld, recorded, walk_through

SENSORS = {"kinect": KINECT, "plain": PLAIN}
# Of the frames at 15/s of each scene, every so many.
STRIDES = {"room": (1, 4, 8), "apartment": (2, 4), "tabletop": (2,)}


def _world(scene: str, stride: int, sensor: str) -> HardWorld:
    recording = partial(recorded, scene, sensor=SENSORS[sensor])
    return HardWorld(f"{scene}, {15 / stride:.3g} frames/s, {sensor}", partial(walk_through, recording, every=stride))


CALIBRATION_WORLDS: dict[str, HardWorld] = {
    f"{scene}-{stride}-{sensor}": _world(scene, stride, sensor)
    for scene, strides in STRIDES.items()
    for stride in strides
    for sensor in SENSORS
}
