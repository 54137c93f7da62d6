"""Fast turns: a camera that is carried slowly and turns to and fro, faster and faster, read row by row."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from data_tools.synthetic.camera.hand_held import looking
from data_tools.synthetic.camera.rolling_shutter import roll
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.camera.walk import FRAMES_PER_S, TURN_DEG_PER_S, usual_frames, walk
from data_tools.synthetic.rendered_sequence import CAMERA, RenderedSequence
from data_tools.synthetic.synthetic_scene import SCENES
from razer.arrays import Float64Array
from razer.frame import Frame

FASTEST_DEG_PER_S = 200.0  # at the end, both turns together
READOUT_S = 0.025
VIDEO_PER_S = 30.0
_PACE = 0.5  # of the usual walk
_PERIOD_S = 1.9  # to and fro
_SOON_S = 0.004  # before and after a moment, between which turning is measured


class FastTurns(RenderedSequence):
    """The room at 30 frames a second along its walk, at half the pace, while the camera swings about its heading: not
    at all in the beginning, and so that it turns by FASTEST_DEG_PER_S in the end. Rolling shutter as of a webcam.

    Args:
        seed: of the room and its walk.
        n_frames: how many, at least 2.
        width: of the images, pixels.
        height: of the images, pixels.
        sensor: what its images suffer besides.
    """

    def __init__(self, seed: int, n_frames: int, width: int, height: int, sensor: SensorModel) -> None:
        world = SCENES["room"](seed)
        usual = usual_frames(world.stations)
        self._way, self._last_s = walk(world.stations, usual, seed), (n_frames - 1) / VIDEO_PER_S
        self._seconds = np.arange(n_frames) / VIDEO_PER_S
        super().__init__(
            f"fast-turns-{seed}",
            world.things,
            self.poses_at(self._seconds),
            CAMERA.resized(width, height),
            sensor,
            seed,
            partial(FastTurns, seed, n_frames, width, height, sensor),
            frames_per_s=VIDEO_PER_S,
            light="day",
            earlier=self.poses_at(self._seconds - 1 / FRAMES_PER_S),
        )

    def __getitem__(self, index: int) -> Frame:
        """One frame, with its colour read row by row; raises IndexError outside the recording."""
        frame = super().__getitem__(index)
        turning_rad_s = self.turning_rad_s(float(self._seconds[index]))
        return replace(frame, rgb=roll(frame.rgb, self.intrinsics, turning_rad_s, READOUT_S))

    def poses_at(self, seconds: Float64Array) -> Float64Array:
        """Poses world_from_camera (N, 4, 4) at times (N,), seconds; before the first frame it stands still."""
        seconds = seconds.clip(0)
        swinging_rad_s = np.radians(FASTEST_DEG_PER_S - _PACE * TURN_DEG_PER_S) * seconds / self._last_s
        swing = swinging_rad_s * _PERIOD_S / (2 * np.pi) * np.sin(2 * np.pi * seconds / _PERIOD_S)
        heading = np.unwrap(np.arctan2(self._way[:, 1, 2], self._way[:, 0, 2]))
        columns = (*self._way[:, :3, 3].T, heading, np.arcsin(self._way[:, 2, 2]))
        frames, places = np.arange(len(self._way)), seconds * FRAMES_PER_S * _PACE
        rows = np.column_stack([np.interp(places, frames, column) for column in columns])
        return np.stack([looking(r[:3], r[3] + s, r[4], np.zeros(2)) for r, s in zip(rows, swing, strict=True)])

    def turning_rad_s(self, moment_s: float) -> Float64Array:
        """How the camera turns about its own axes (3,) at a moment."""
        before, after = self.poses_at(np.array([moment_s - _SOON_S, moment_s + _SOON_S]))
        turned = Rotation.from_matrix(before[:3, :3].T @ after[:3, :3]).as_rotvec()
        return turned / (2 * _SOON_S if moment_s >= _SOON_S else _SOON_S)
