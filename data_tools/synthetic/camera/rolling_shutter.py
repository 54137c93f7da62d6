"""Rolling shutter: an image read row by row while the camera turns."""

from __future__ import annotations

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from razer.arrays import Float64Array, Uint8Array
from razer.frame import Intrinsics


def roll(rgb: Uint8Array, camera: Intrinsics, turning_rad_s: Float64Array, readout_s: float) -> Uint8Array:
    """What a camera that turns shows of a view (H, W, 3): each row is of its own moment, the middle one of the view's.

    That the camera also moves on is left out, as a readout is too short for a shift to be seen. What comes into view
    from beyond the border repeats the border.

    Args:
        rgb: the view from the pose of the middle row.
        camera: its intrinsics.
        turning_rad_s: (3,) how the camera turns about its own axes.
        readout_s: from the reading of the first row to that of the last, seconds.
    """
    when_s = (np.arange(camera.height) / (camera.height - 1) - 0.5) * readout_s
    middle_from_row = Rotation.from_rotvec(when_s[:, None] * turning_rad_s).as_matrix()
    x, y = (np.arange(camera.width) - camera.cx) / camera.fx, (np.arange(camera.height) - camera.cy) / camera.fy
    rays = np.stack([*np.meshgrid(x, y), np.ones((camera.height, camera.width))], axis=-1)
    seen = np.einsum("vij,vuj->vui", middle_from_row, rays)
    u, v = seen[..., 0] / seen[..., 2] * camera.fx + camera.cx, seen[..., 1] / seen[..., 2] * camera.fy + camera.cy
    return cv2.remap(rgb, u.astype(np.float32), v.astype(np.float32), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
