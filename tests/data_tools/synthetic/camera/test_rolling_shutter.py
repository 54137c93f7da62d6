"""Rolling shutter: each row is what a camera that had turned so far would show there."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from data_tools.synthetic.camera.rolling_shutter import roll
from razer.frame import Intrinsics

CAMERA = Intrinsics(160, 120, 140.0, 140.0, 79.5, 59.5)


def sky(turned: Rotation) -> np.ndarray:
    """A picture on the inside of a sphere, smooth and without end, from a camera turned so."""
    x, y = np.meshgrid((np.arange(160) - 79.5) / 140, (np.arange(120) - 59.5) / 140)
    rays = turned.apply(np.stack([x, y, np.ones_like(x)], axis=-1).reshape(-1, 3)).reshape(120, 160, 3)
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    waves = [np.sin(9 * rays[..., 0] + 3), np.sin(11 * rays[..., 1]), np.sin(7 * rays[..., 2] + 8 * rays[..., 0])]
    return np.rint(127 + 120 * np.stack(waves, axis=-1)).astype(np.uint8)


@pytest.mark.parametrize("turning_deg_s", [(0, 200, 0), (200, 0, 0), (0, 0, 150), (90, -120, 60)])
def test_each_row_is_that_of_its_own_moment(turning_deg_s):
    turning = np.radians(turning_deg_s).astype(float)
    rolled = roll(sky(Rotation.identity()), CAMERA, turning, 0.03).astype(float)
    for row in (0, 20, 59, 60, 100, 119):
        moment_s = (row / 119 - 0.5) * 0.03
        then = sky(Rotation.from_rotvec(moment_s * turning)).astype(float)
        # Beyond the border nothing is known: as far as the view turns within half the readout.
        assert np.abs(rolled[row] - then[row])[20:-20].max() < 3 or row in (0, 119)
    assert np.abs(rolled[20:-20, 20:-20] - sky(Rotation.identity())[20:-20, 20:-20]).max() > 5


def test_a_camera_that_stands_still_shows_what_there_is():
    view = sky(Rotation.identity())
    assert np.array_equal(roll(view, CAMERA, np.zeros(3), 0.03), view)
    assert np.array_equal(roll(view, CAMERA, np.ones(3), 0.0), view)
