"""Hand-crafted appearance descriptors: histograms of colour, texture and shape for each mask, without weights."""

from __future__ import annotations

import cv2
import numpy as np

from razer.arrays import BoolArray, Float32Array, Float64Array, Int64Array, Uint8Array
from razer.errors import BadInput
from razer.frame import Frame, Intrinsics, Masks

_SAMPLE_STRIDE = 4  # pixels at 640x480; every fourth is enough for a mask's colours
_CHROMA_BINS, _LIGHT_BINS, _TEXTURE_BINS, _SIZE_BINS, _SHAPE_BINS = 6, 8, 6, 7, 4
# Proportions change most with the point of view, so they have the lowest weight.
_WEIGHTS = {"chroma": 1.0, "light": 1.0, "texture": 0.6, "size": 0.35, "flat": 0.25, "long": 0.25}


class AppearanceEmbedder:
    """Soft histograms of colour (Lab), lightness and gradient, and of size and proportions in metres.

    It separates masks of one recording and ranks by likeness, so it serves association and queries by
    image. It knows no language: there is no text encoder. Each block of the vector is the square root of a histogram
    (so that a product is the Bhattacharyya coefficient) less that of an even one, which keeps unrelated masks
    near a cosine of zero; blocks are weighted and the whole has unit length.
    """

    dimension = _CHROMA_BINS**2 + _LIGHT_BINS + _TEXTURE_BINS + _SIZE_BINS + 2 * _SHAPE_BINS

    def embed(self, frame: Frame, masks: Masks) -> Float32Array:
        """Unit vectors (N, dimension) float32; an empty mask gets a constant one."""
        if len(masks) == 0:
            return np.zeros((0, self.dimension), np.float32)
        stride = max(1, round(_SAMPLE_STRIDE * frame.intrinsics.width / 640))
        owner, pixel = _samples(masks.masks, stride)
        blocks = {
            **_colour_blocks(frame, stride, owner, pixel, len(masks)),
            **_shape_blocks(frame, stride, owner, pixel, len(masks)),
        }
        vectors = np.concatenate([_WEIGHTS[name] * _centred(block) for name, block in blocks.items()], axis=1)
        length = np.linalg.norm(vectors, axis=1, keepdims=True)
        even = np.full(vectors.shape, vectors.shape[1] ** -0.5)
        return np.where(length > 1e-6, vectors / np.maximum(length, 1e-6), even).astype(np.float32)

    def embed_region(self, rgb: Uint8Array, mask: BoolArray) -> Float32Array:
        """The vector (dimension,) of colour and texture alone, as an image has no metric size. Raises BadInput for an
        empty mask."""
        if not mask.any():
            raise BadInput("the picture's box or mask is empty: give one that covers something")
        height, width = mask.shape
        camera = Intrinsics(width, height, float(width), float(width), width / 2, height / 2)
        frame = Frame(0, 0.0, rgb, np.zeros((height, width), np.float32), camera)
        vector: Float32Array = self.embed(frame, Masks(mask[None], np.ones(1, np.float32)))[0]
        return vector


def _samples(masks: BoolArray, stride: int) -> tuple[Int64Array, Int64Array]:
    """Mask number and grid position of each sampled pixel; every mask with pixels has a sample."""
    grid = np.ascontiguousarray(masks[:, ::stride, ::stride])
    for missed in np.flatnonzero(~grid.any(axis=(1, 2))):
        for row, column in np.argwhere(masks[missed])[:1] // stride:
            grid[missed, row, column] = True
    owner, pixel = np.divmod(np.flatnonzero(grid), grid[0].size)
    return owner, pixel


def _colour_blocks(frame: Frame, stride: int, owner: Int64Array, pixel: Int64Array, n: int) -> dict[str, Float64Array]:
    size = tuple(-(-side // stride) for side in frame.depth.shape)
    small = cv2.resize(frame.rgb, size[::-1], interpolation=cv2.INTER_AREA)
    lab = cv2.cvtColor(small, cv2.COLOR_RGB2LAB)
    light = cv2.GaussianBlur(lab[..., 0], (0, 0), 0.7).astype(np.float32)
    gradient = np.hypot(cv2.Sobel(light, cv2.CV_32F, 1, 0), cv2.Sobel(light, cv2.CV_32F, 0, 1)) / 8
    values = lab.reshape(-1, 3)[pixel].astype(np.float64)
    chroma = [_compressed((values[:, channel] - 128) / 12) for channel in (1, 2)]
    texture = np.log1p(gradient.ravel()[pixel].astype(np.float64)) / np.log(60)
    return {
        "chroma": _soft_histogram_2d(owner, chroma[0], chroma[1], n, _CHROMA_BINS),
        "light": _soft_histogram(owner, values[:, 0] / 255, n, _LIGHT_BINS),
        "texture": _soft_histogram(owner, texture, n, _TEXTURE_BINS),
    }


def _compressed(value: Float64Array) -> Float64Array:
    """[-inf, inf] to [0, 1], finest about 0, where the colours of rooms crowd."""
    return 0.5 + value / (1 + np.abs(value)) / 2


def _shape_blocks(frame: Frame, stride: int, owner: Int64Array, pixel: Int64Array, n: int) -> dict[str, Float64Array]:
    """Longest extent on a log scale from 5 cm to 5 m, and the two proportions of the scatter's axes."""
    camera = frame.intrinsics
    depth = frame.depth[::stride, ::stride]
    v, u = np.divmod(pixel, depth.shape[1])
    z = depth.ravel()[pixel].astype(np.float64)
    has_depth = z > 0
    owner, z, u, v = owner[has_depth], z[has_depth], u[has_depth] * stride, v[has_depth] * stride
    points = np.stack([(u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z])
    count = np.bincount(owner, minlength=n)
    share = 1 / np.maximum(count, 1)
    mean = np.stack([np.bincount(owner, axis, n) for axis in points]) * share
    centred = points - mean[:, owner]
    scatter = np.zeros((n, 3, 3))
    for row, column in ((0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)):  # the lower triangle is all that is read
        scatter[:, row, column] = np.bincount(owner, centred[row] * centred[column], n) * share
    spread = np.sqrt(np.maximum(np.linalg.eigvalsh(scatter), 1e-8))
    measured = np.flatnonzero(count > 0)
    thin, middle, length = (spread[measured] * 12**0.5).T
    return {
        "size": _soft_histogram(measured, np.log(length / 0.05) / np.log(100), n, _SIZE_BINS),
        "flat": _soft_histogram(measured, np.sqrt(thin / middle), n, _SHAPE_BINS),
        "long": _soft_histogram(measured, np.sqrt(middle / length), n, _SHAPE_BINS),
    }


def _soft_histogram(owner: Int64Array, value: Float64Array, n: int, bins: int) -> Float64Array:
    """Share of each owner's values (in [0, 1]) near each of the bins' centres, (n, bins); rows sum to 1 or 0."""
    low, upper = _between(value, bins)
    counts = np.zeros(n * bins)
    for step, share in ((0, 1 - upper), (1, upper)):
        counts += np.bincount(owner * bins + low + step, share, len(counts))
    return _shares(counts.reshape(n, bins))


def _soft_histogram_2d(owner: Int64Array, first: Float64Array, second: Float64Array, n: int, bins: int) -> Float64Array:
    """As _soft_histogram, over pairs of values, (n, bins * bins)."""
    (low_a, upper_a), (low_b, upper_b) = _between(first, bins), _between(second, bins)
    counts = np.zeros(n * bins * bins)
    keys = (owner * bins + low_a) * bins + low_b
    for step_a, share_a in ((0, 1 - upper_a), (1, upper_a)):
        for step_b, share_b in ((0, 1 - upper_b), (1, upper_b)):
            counts += np.bincount(keys + (step_a * bins + step_b), share_a * share_b, len(counts))
    return _shares(counts.reshape(n, bins * bins))


def _between(value: Float64Array, bins: int) -> tuple[Int64Array, Float64Array]:
    """The bin centre below each value and how far the value is on its way to the next."""
    position = np.clip(value, 0, 1) * (bins - 1)
    low = np.minimum(position.astype(np.int64), bins - 2)
    return low, position - low


def _shares(counts: Float64Array) -> Float64Array:
    return counts / np.maximum(counts.sum(axis=1, keepdims=True), 1e-9)


def _centred(shares: Float64Array) -> Float64Array:
    return np.sqrt(shares) - np.sqrt(shares).mean(axis=1, keepdims=True)
