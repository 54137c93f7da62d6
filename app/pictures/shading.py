"""Light on a picture: a soft lamp beside the camera and the sky, and ambient occlusion in the image."""

from __future__ import annotations

import cv2
import numpy as np

from app.pictures.camera import PictureCamera
from razer.arrays import BoolArray, Float32Array, Float64Array

_AMBIENT, _SKY, _LAMP = 0.60, 0.16, 0.34
_LAMP_RIGHT, _LAMP_UP = -0.45, 0.75  # where the lamp stands beside the camera, for 1 towards it

OCCLUSION_RADIUS_M = 0.45
_STRENGTH = 1.15
_LEAST_OPENNESS = 0.45
_SLOPE_BIAS = 0.08  # rough surfaces do not darken themselves
_RINGS, _SPOKES = 4, 6
_BLUR_PX = 2.0
_MAX_PX = 1_000_000  # of the image that occlusion is reckoned on


def lit(normals: Float64Array, axes: Float64Array, up: Float64Array) -> Float32Array:
    """Brightness (V,) of vertices with unit normals (V, 3), seen by a camera with these axes (Lambert; hemisphere of
    light)."""
    right, down, forward = axes
    lamp = _LAMP_RIGHT * right - _LAMP_UP * down - forward
    lamp /= np.linalg.norm(lamp)
    towards_lamp = np.clip(normals @ lamp, 0, None)
    towards_sky = 0.5 + 0.5 * (normals @ up)
    return (_AMBIENT + _SKY * towards_sky + _LAMP * towards_lamp).astype(np.float32)


def openness(distance: Float32Array, camera: PictureCamera) -> Float32Array:
    """Share (H, W) of ambient light that reaches each pixel, by what its neighbours hide (McGuire et al., 2011).

    Args:
        distance: (H, W), metres from the eye, infinite where nothing is.
        camera: that of the image.
    """
    step = max(1, int(np.ceil(np.sqrt(distance.size / _MAX_PX))))
    small = distance[step // 2 :: step, step // 2 :: step]
    covered = np.isfinite(small)
    if not covered.any():
        return np.ones(distance.shape, np.float32)
    points = _points(small, camera, step)
    reach_px = max(2.0, _pixels_per_m(small[covered], camera) / step * OCCLUSION_RADIUS_M)
    hidden = _hidden(points, covered, reach_px)
    share = cv2.GaussianBlur(np.where(covered, hidden, 0).astype(np.float32), (0, 0), _BLUR_PX)
    weight = cv2.GaussianBlur(covered.astype(np.float32), (0, 0), _BLUR_PX)
    light = np.clip(1 - _STRENGTH * share / np.maximum(weight, 1e-3), _LEAST_OPENNESS, 1)
    width, height = distance.shape[1], distance.shape[0]
    large: Float32Array = cv2.resize(light.astype(np.float32), (width, height), interpolation=cv2.INTER_LINEAR)
    return large


def _points(distance: Float32Array, camera: PictureCamera, step: int) -> Float32Array:
    """Positions (H, W, 3) in the camera's axes, metres; far away where nothing is."""
    height, width = distance.shape
    far = np.where(np.isfinite(distance), distance, 1e6).astype(np.float32)
    x = ((np.arange(width) * step + step // 2 + 0.5 - camera.center_px[0]) / camera.focal_px).astype(np.float32)
    y = ((np.arange(height) * step + step // 2 + 0.5 - camera.center_px[1]) / camera.focal_px).astype(np.float32)
    if camera.is_orthographic:
        return np.dstack([np.broadcast_to(x, far.shape), np.broadcast_to(y[:, None], far.shape), far])
    forward = far / np.sqrt(1 + x**2 + y[:, None] ** 2)
    return np.dstack([forward * x, forward * y[:, None], forward])


def _pixels_per_m(distance: Float32Array, camera: PictureCamera) -> float:
    return camera.focal_px if camera.is_orthographic else camera.focal_px / float(np.median(distance))


def _normals(points: Float32Array) -> Float32Array:
    """Unit normals (H, W, 3) towards the camera, from the nearer neighbour on each side, as edges are none."""

    def slope(axis: int) -> Float32Array:
        step = np.diff(points, axis=axis)
        before = np.concatenate([np.take(step, [0], axis), step], axis=axis)
        after = np.concatenate([step, np.take(step, [-1], axis)], axis=axis)
        flatter = np.abs(before[..., 2:]) < np.abs(after[..., 2:])
        return np.where(flatter, before, after).astype(np.float32)

    normals = np.cross(slope(0), slope(1))
    normals *= np.where(normals[..., 2:] > 0, -1, 1)
    return (normals / np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-12)).astype(np.float32)


def _hidden(points: Float32Array, covered: BoolArray, reach_px: float) -> Float32Array:
    """How much (H, W) of the view from each pixel its neighbours within the reach hide."""
    height, width = covered.shape
    normals = _normals(points)
    total = np.zeros(covered.shape, np.float32)
    rim = int(np.ceil(reach_px)) + 1
    padded = cv2.copyMakeBorder(points, rim, rim, rim, rim, cv2.BORDER_REPLICATE)
    for ring in range(_RINGS):
        radius = reach_px * ((ring + 1) / _RINGS) ** 1.5
        for spoke in range(_SPOKES):
            turn = 2 * np.pi * (spoke + 0.37 * ring) / _SPOKES
            row, column = rim + round(radius * np.sin(turn)), rim + round(radius * np.cos(turn))
            away = padded[row : row + height, column : column + width] - points
            squared = np.einsum("ijk,ijk->ij", away, away)
            raised = np.einsum("ijk,ijk->ij", away, normals) / np.sqrt(squared + 1e-9) - _SLOPE_BIAS
            near = np.clip(1 - squared / OCCLUSION_RADIUS_M**2, 0, 1)
            total += np.clip(raised, 0, None) * near
    share: Float32Array = total * np.float32(2 / (_RINGS * _SPOKES))
    return share
