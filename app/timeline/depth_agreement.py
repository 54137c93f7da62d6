"""How well depth images agree under poses: each is looked at from where the others were taken.

Poses that are off put one wall at two depths. This asks no map, which may be bent or blurred and look whole.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np

from razer.arrays import Float32Array, Float64Array
from razer.frame import Intrinsics
from razer.geometry import inverse, transform_points

MAX_IMAGES = 30  # evenly over the run; pairs go with the square
MAX_EDGE = 80  # pixels that are looked at, along the longer edge
OTHER_SURFACE_M = 0.15  # farther apart two readings are of two surfaces, one before the other
FEWEST_READINGS = 300  # of a pair of images, seen in both


def pair_offsets_m(
    depths_m: Sequence[Float32Array], camera: Intrinsics, world_from_camera: Float64Array
) -> Float64Array:
    """For each ordered pair of images the median distance between the depth that one shows and that which the other
    puts there, metres; NaN where they see too little in common.

    Args:
        depths_m: N images (H, W), 0 = none.
        camera: of all of them.
        world_from_camera: (N, 4, 4).
    """
    step = -(-max(camera.width, camera.height) // MAX_EDGE)
    clouds = [_points(depth, camera, step) for depth in depths_m]
    offsets = [
        _offset_m(
            transform_points(inverse(world_from_camera[b]) @ world_from_camera[a], clouds[a]), depths_m[b], camera
        )
        for a, b in permutations(range(len(depths_m)), 2)
    ]
    return np.array(offsets)


def _points(depth_m: Float32Array, camera: Intrinsics, step: int) -> Float64Array:
    """Every `step`-th reading as a point (N, 3) before the camera."""
    rows, columns = np.mgrid[0 : camera.height : step, 0 : camera.width : step]
    z = depth_m[rows, columns].astype(np.float64)
    x, y = (columns - camera.cx) / camera.fx * z, (rows - camera.cy) / camera.fy * z
    return np.stack([x, y, z], axis=-1)[z > 0]


def _offset_m(points: Float64Array, depth_m: Float32Array, camera: Intrinsics) -> float:
    points = points[points[:, 2] > 0.1]
    columns = np.rint(camera.fx * points[:, 0] / points[:, 2] + camera.cx).astype(int)
    rows = np.rint(camera.fy * points[:, 1] / points[:, 2] + camera.cy).astype(int)
    inside = (columns >= 0) & (columns < camera.width) & (rows >= 0) & (rows < camera.height)
    shown = depth_m[rows[inside], columns[inside]]
    apart = np.abs(shown - points[inside, 2])[shown > 0]
    apart = apart[apart < OTHER_SURFACE_M]
    return float(np.median(apart)) if len(apart) >= FEWEST_READINGS else float("nan")
