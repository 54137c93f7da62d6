"""Colour sensor errors: motion blur, misregistration, exposure drift and noise on (H, W, 3) uint8 images."""

from __future__ import annotations

import cv2
import numpy as np

from data_tools.synthetic.camera.noise_fields import whole_normal
from razer.arrays import Float32Array, Float64Array, Uint8Array
from razer.frame import Intrinsics
from razer.geometry import inverse

_SHORT_PX = 6.0  # longer blurs are made of shorter ones: large kernels are slow
_LONGEST_PX = 48.0
_ROLL_FRAMES = 200
_DRIFT_FRAMES = (90, 240)


def blur_px(
    poses: Float64Array, index: int, camera: Intrinsics, shutter: float, before: Float64Array | None = None
) -> Float64Array:
    """Motion blur (2,) in pixels of the image's middle, by the camera's rotation since a short time before.

    Args:
        poses: (N, 4, 4) world_from_camera of the recording.
        index: the frame.
        camera: its intrinsics.
        shutter: share of that time for which the shutter is open.
        before: the pose (4, 4) at that time before; None = that of the frame before.
    """
    if before is None:
        before = poses[index - 1 if index else min(1, len(poses) - 1)]
    x, y, z = (inverse(poses[index]) @ before)[:3, 2]
    flow = shutter * np.array([camera.fx * x, camera.fy * y]) / max(z, 0.1)
    return flow * min(1, _LONGEST_PX / max(float(np.hypot(*flow)), 1e-9))


def rolling_offset_px(size_px: float, seed: int, index: int) -> Float64Array:
    """By how much (2,) colour is shifted against depth: always size_px, in a slowly turning direction."""
    start = np.random.default_rng([seed, 11]).uniform(0, 2 * np.pi)
    angle = start + 2 * np.pi * index / _ROLL_FRAMES
    return size_px * np.array([np.cos(angle), np.sin(angle)])


def exposure(drift: float, seed: int, index: int) -> float:
    """The factor on all colours, slowly moving within 1 - drift .. 1 + drift."""
    rng = np.random.default_rng([seed, 12])
    periods, phases = rng.uniform(*_DRIFT_FRAMES, 3), rng.uniform(0, 2 * np.pi, 3)
    return 1 + drift * float(np.sin(2 * np.pi * index / periods + phases).mean())


def smear(rgb: Uint8Array, flow_px: Float64Array, offset_px: Float64Array) -> Uint8Array:
    """Colour shifted by an offset (2,) and blurred evenly along a way (2,), both in pixels."""
    if np.hypot(*flow_px) <= _SHORT_PX:
        return cv2.filter2D(rgb, -1, _line(flow_px, offset_px), borderType=cv2.BORDER_REPLICATE)
    apart = np.rint(flow_px / 2).astype(int)
    ahead, behind = apart // 2, apart // 2 - apart
    half = smear(rgb, flow_px - apart, offset_px - (ahead + behind) / 2)
    return cv2.addWeighted(_shifted(half, *ahead), 0.5, _shifted(half, *behind), 0.5, 0)


def add_noise(rgb: Uint8Array, sigma: float, rng: np.random.Generator) -> Uint8Array:
    """Independent noise of sigma grey levels on every channel."""
    return cv2.add(rgb, whole_normal(rgb.shape, sigma, rng), dtype=cv2.CV_8U)


def expose(rgb: Uint8Array, gain: float) -> Uint8Array:
    """All colours times a factor, cut off at white."""
    return cv2.convertScaleAbs(rgb, alpha=gain)


def _line(flow_px: Float64Array, offset_px: Float64Array) -> Float32Array:
    """The kernel that puts a pixel's colour evenly along a line about itself + offset_px."""
    count = 2 * int(np.ceil(np.hypot(*flow_px))) + 1
    share = (np.arange(count) + 0.5) / count - 0.5
    # Correlation looks up where it puts to: the offset changes sign.
    places = share[:, None] * flow_px - offset_px
    radius = int(np.ceil(np.abs(places).max()))
    kernel = np.zeros((2 * radius + 2, 2 * radius + 2))
    low = np.floor(places).astype(int)
    x, y = (places - low).T
    column, row = (low + radius).T
    for across, down, weight in ((0, 0, (1 - x) * (1 - y)), (1, 0, x * (1 - y)), (0, 1, (1 - x) * y), (1, 1, x * y)):
        np.add.at(kernel, (row + down, column + across), weight)
    return (kernel[:-1, :-1] / count).astype(np.float32)


def _shifted(rgb: Uint8Array, x: int, y: int) -> Uint8Array:
    """The image moved by whole pixels, its border drawn out."""
    height, width = rgb.shape[:2]
    margin = max(abs(x), abs(y))
    padded = cv2.copyMakeBorder(rgb, margin, margin, margin, margin, cv2.BORDER_REPLICATE)
    return padded[margin - y : margin - y + height, margin - x : margin - x + width]
