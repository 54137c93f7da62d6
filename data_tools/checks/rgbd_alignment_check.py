"""Check of the alignment of colour and depth by their edges: depth jumps where colour changes.

Of all ways to mirror, zoom and shift the depth edges, summed over frames, the one is sought that puts them where
colour changes most. Mirrored edges on unmirrored colour fit nowhere, which tells what chance can do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.arrays import Float32Array, Float64Array, Uint8Array
from razer.frame import Frame, Intrinsics

_WIDTH = 160  # images are looked at in this size
_ZOOMS = np.geomspace(1 / 1.4, 1.4, 29)  # the middle one is 1
_REACH = 0.13  # largest shift, share of the width
_MAX_FRAMES = 12
_MIN_EDGES = 300
_JUMP = 1.1  # ratio of depths across an edge
_SHADOW_PX = 31  # of images 320 wide: gaps beside near things, where projector and camera see differently
_MIN_FIT = 0.25  # deviations of colour change
_CLEAR = 1.7  # how many times better than chance a fit must be
# How much of the best fit the images as they are, or moved by little, must reach to be believed: near things, blur
# and gaps in depth draw the best fit away from the truth.
_AS_GOOD_AS_IS, _AS_GOOD_SMALL = 0.6, 0.95
# Where colour is moved by less, it is only noted: raw Kinect recordings (7-Scenes: zoom 0.90, 8 of 640 pixels)
# are mapped well enough.
_MAX_SHIFT, _MAX_ZOOM = 0.02, 1.13
_NOTED = 0.008  # mean displacement, share of the width


@dataclass(frozen=True, slots=True)
class RgbdAlignmentReport:
    """Where colour shows what depth shows: depth pixel p, from the middle of the image, lies at zoom p + shift_px
    (x, y) in colour, mirrored left to right first if so; `clear` tells whether the images say so beyond doubt."""

    clear: bool
    mirrored: bool = False
    zoom: float = 1.0
    shift_px: tuple[float, float] = (0.0, 0.0)
    mean_px: float = 0.0
    width: int = 1

    @property
    def wrong(self) -> bool:
        """Whether colour belongs to another camera."""
        far = float(np.hypot(*self.shift_px)) > _MAX_SHIFT * self.width
        return self.clear and (self.mirrored or far or abs(np.log(self.zoom)) > np.log(_MAX_ZOOM))

    @property
    def noticeable(self) -> bool:
        """Whether colour is off, little or much."""
        return self.clear and (self.mirrored or self.mean_px > _NOTED * self.width)

    def __str__(self) -> str:
        if not self.clear:
            return "too few edges to tell"
        if not self.noticeable:
            return "colour and depth fit"
        flipped = "mirrored and " if self.mirrored else ""
        x, y = self.shift_px
        return (
            f"colour is {flipped}zoomed by {self.zoom:.2f} and shifted by {x:+.0f} {y:+.0f} pixels "
            f"against depth, {self.mean_px:.0f} on average"
        )


def check_rgbd_alignment(frames: Sequence[Frame]) -> RgbdAlignmentReport:
    """Judge the alignment of colour and depth from a dozen frames; about a second."""
    chosen = frames[:: max(len(frames) // _MAX_FRAMES, 1)]
    pairs = [(_colour_edges(frame.rgb), _depth_edges(frame.depth)) for frame in chosen]
    pairs = [(colour, depth) for colour, depth in pairs if depth.sum() > 0]
    if sum(float(depth.sum()) for _, depth in pairs) < _MIN_EDGES:
        return RgbdAlignmentReport(clear=False)
    straight, mirrored = (np.stack([_fits(pairs, zoom, mirror) for zoom in _ZOOMS]) for mirror in (False, True))
    middle = len(_ZOOMS) // 2, straight.shape[1] // 2, straight.shape[2] // 2
    best, other = (mirrored, straight) if mirrored.max() > straight.max() else (straight, mirrored)
    if best.max() < max(_MIN_FIT, _CLEAR * float(other.max())):
        return RgbdAlignmentReport(clear=False)
    if best is straight:
        best = _prefer_small(straight, middle)
    return _report(best, middle, best is mirrored, chosen[0].intrinsics)


def _prefer_small(fits: NDArray, middle: tuple[int, ...]) -> NDArray:
    """The fits among which to look for the best: only that of the images as they are, only those too small to
    matter, or all, the first that hold one about as good as the best of all."""
    zoom, down, across = np.ogrid[tuple(slice(size) for size in fits.shape)]
    small = np.abs(np.log(_ZOOMS))[zoom] <= np.log(_MAX_ZOOM)
    small = small & (np.hypot(down - middle[1], across - middle[2]) <= _MAX_SHIFT * _WIDTH)
    as_is = np.zeros_like(small)
    as_is[middle] = True
    for enough, chosen in ((_AS_GOOD_AS_IS, as_is), (_AS_GOOD_SMALL, small)):
        if fits[chosen].max() > enough * fits.max():
            return np.where(chosen, fits, -np.inf)
    return fits


def _report(fits: NDArray, middle: tuple[int, ...], mirrored: bool, camera: Intrinsics) -> RgbdAlignmentReport:
    zoom, down, across = np.unravel_index(fits.argmax(), fits.shape)
    pixel = camera.width / _WIDTH
    shift = (across - middle[2]) * pixel, (down - middle[1]) * pixel
    x = np.linspace(-0.5, 0.5, 40) * camera.width
    y = np.linspace(-0.5, 0.5, 30)[:, None] * camera.height
    enlarged = float(_ZOOMS[zoom]) - 1
    away = np.hypot(enlarged * x + shift[0], enlarged * y + shift[1])
    return RgbdAlignmentReport(
        True, mirrored, float(_ZOOMS[zoom]), (float(shift[0]), float(shift[1])), float(away.mean()), camera.width
    )


def _fits(pairs: list[tuple[Float32Array, Float32Array]], zoom: float, mirror: bool) -> Float64Array:
    """Mean colour change (in deviations from its mean) under the depth edges, for every shift (down, across)."""
    edges = [_zoomed(np.ascontiguousarray(depth[:, ::-1]) if mirror else depth, zoom) for _, depth in pairs]
    total = np.sum([_shifted_products(colour, moved) for (colour, _), moved in zip(pairs, edges, strict=True)], axis=0)
    # Edges shifted beyond the border meet no colour at all, and do not count.
    weight = _shifted_products(np.ones_like(edges[0]), np.sum(edges, axis=0))
    return np.where(weight > 0.3 * weight.max(), total / np.maximum(weight, 1e-9), 0.0)


def _shifted_products(image: Float32Array, moved: Float32Array) -> Float32Array:
    """Sum of the products of two images for every shift of the second within reach."""
    reach = int(_REACH * _WIDTH)
    padded = cv2.copyMakeBorder(image, reach, reach, reach, reach, cv2.BORDER_CONSTANT, value=0)
    return cv2.matchTemplate(padded, moved, cv2.TM_CCORR).astype(np.float32)


def _zoomed(image: Float32Array, zoom: float) -> Float32Array:
    height, width = image.shape
    x, y = (1 - zoom) * (width - 1) / 2, (1 - zoom) * (height - 1) / 2
    return cv2.warpAffine(image, np.array([[zoom, 0, x], [0, zoom, y]]), (width, height)).astype(np.float32)


def _colour_edges(rgb: Uint8Array) -> Float32Array:
    """How much colour changes at each pixel of a small image, strong changes all alike; mean 0, deviation 1."""
    grey = cv2.GaussianBlur(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), None, 1.0)
    change = _small(np.hypot(cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1)))
    change = np.minimum(change / max(float(np.quantile(change, 0.9)), 1e-6), 1)
    return ((change - change.mean()) / max(float(change.std()), 1e-6)).astype(np.float32)


def _depth_edges(depth: Float32Array) -> Float32Array:
    """The rim of near things before far ones: share of the pixels of a small image."""
    step = max(depth.shape[1] // (2 * _WIDTH), 1)
    depth = np.ascontiguousarray(depth[::step, ::step])
    closed = cv2.morphologyEx(depth, cv2.MORPH_CLOSE, np.ones((5, _SHADOW_PX), np.uint8))
    filled = np.where(depth > 0, depth, closed)
    behind = cv2.dilate(filled, np.ones((3, 3), np.uint8))
    return _small(((filled > 0) & (behind > _JUMP * filled)).astype(np.float32))


def _small(image: Float32Array) -> Float32Array:
    height = round(_WIDTH * image.shape[0] / image.shape[1])
    return cv2.resize(image, (_WIDTH, height), interpolation=cv2.INTER_AREA).astype(np.float32)
