"""Features of image regions and of their borders: colour, position, size, plane, edge strength."""

from __future__ import annotations

import cv2
import numpy as np

from razer.arrays import Float32Array, Float64Array, Int32Array, Uint8Array
from razer.frame import Intrinsics
from razer.models.geometric.local_planes import LocalPlanes
from razer.models.geometric.region_graph import RegionGraph
from razer.models.geometric.region_planes import N_SUMS, plane_sums
from razer.models.geometric.surface_edges import STRONGEST

# Columns of RegionGraph.sums (Lab units, metres, square metres) and of RegionGraph.boundary (metres).
COUNT, LIGHT, RED_GREEN, YELLOW_BLUE, X, Y, Z, SQUARE, AREA = range(9)
PLANE = slice(9, 9 + N_SUMS)
LENGTH, STRENGTH, GAP = range(3)

_STRIDE = 2  # pixels; means over a region need only every second one in each direction
_MAX_GAP_M = 0.3
_FULL_COLOUR_DIFFERENCE = 30.0  # Lab units
_LIGHT_WEIGHT = 0.3  # illumination is uneven: lightness is less reliable than hue


def region_graph(
    labels: Int32Array,
    n: int,
    planes: LocalPlanes,
    borders: tuple[Float32Array, Float32Array],
    rgb: Uint8Array,
    camera: Intrinsics,
) -> RegionGraph:
    """The graph, with the columns named above, of the regions in a label image.

    Args:
        labels: (h, w), region numbers, -1 = unlabelled.
        n: number of regions.
        planes: of the label image.
        borders: strengths towards the right and the lower neighbour, as from edge_strengths.
        rgb: (H, W, 3), at any resolution.
        camera: intrinsics of the label image.
    """
    depth = np.where(planes.valid, 1 / np.maximum(planes.value, np.float32(0.05)), np.float32(0))
    right, below = (_border(depth, strength, axis) for strength, axis in zip(borders, (1, 0), strict=True))
    labels = np.where(planes.valid, labels, -1)
    return RegionGraph.of(labels, n, _pixels(depth, rgb, camera), (right, below), _STRIDE)


def _border(depth: Float32Array, strength: Float32Array, axis: int) -> Float32Array:
    gap = np.minimum(np.abs(np.diff(depth, axis=axis, append=0)), np.float32(_MAX_GAP_M))
    across = np.ones((1, 3) if axis == 1 else (3, 1), np.uint8)
    # The border may lie a pixel beside the edge: the strongest of three counts.
    return np.stack([np.ones_like(gap), cv2.dilate(strength, across), cv2.dilate(gap, across)])


def _pixels(depth: Float32Array, rgb: Uint8Array, camera: Intrinsics) -> Float32Array:
    z = depth[::_STRIDE, ::_STRIDE]
    small = cv2.resize(rgb, z.shape[::-1], interpolation=cv2.INTER_AREA)
    lab = cv2.cvtColor(small, cv2.COLOR_RGB2LAB).astype(np.float32).transpose(2, 0, 1)
    u = np.arange(0, depth.shape[1], _STRIDE, dtype=np.float32)
    v = np.arange(0, depth.shape[0], _STRIDE, dtype=np.float32)[:, None]
    u, v = (u - np.float32(camera.cx)) / np.float32(camera.fx), (v - np.float32(camera.cy)) / np.float32(camera.fy)
    x, y, area = z * u, z * v, z * z * np.float32(_STRIDE**2 / (camera.fx * camera.fy))
    inverse = np.reciprocal(np.where(z > 0, z, np.float32(np.inf)))
    per_pixel = np.stack([np.ones_like(z), *lab, x, y, z, x * x + y * y + z * z, area])
    return np.concatenate([per_pixel, plane_sums(inverse, u, v)])


def colour_difference(graph: RegionGraph) -> Float64Array:
    """Difference of mean colour of the two regions of each pair (E,), in [0, 1]."""
    colour = graph.sums[:, [LIGHT, RED_GREEN, YELLOW_BLUE]] / np.maximum(graph.sums[:, [COUNT]], 1)
    light, red_green, yellow_blue = np.abs(colour[graph.pairs[:, 0]] - colour[graph.pairs[:, 1]]).T
    difference = np.hypot(red_green, yellow_blue) + _LIGHT_WEIGHT * light
    return np.clip(difference / _FULL_COLOUR_DIFFERENCE, 0, 1)


def size_m(sums: Float64Array) -> Float64Array:
    """Length (N,) of the straight rod with the same scatter as each row's points: about the diagonal, metres."""
    count = np.maximum(sums[:, COUNT], 1)
    mean = sums[:, [X, Y, Z]] / count[:, None]
    return np.sqrt(12 * np.maximum(sums[:, SQUARE] / count - (mean**2).sum(axis=1), 0))


def distinctness(graph: RegionGraph) -> Float32Array:
    """Mean strength (N,) of each region's borders to its neighbours, in [0, 1]; 0.5 where it has none."""
    both = np.concatenate([graph.pairs[:, 0], graph.pairs[:, 1]])
    length, strength = (
        np.bincount(both, np.tile(graph.boundary[:, column], 2), len(graph.sums)) for column in (LENGTH, STRENGTH)
    )
    return np.where(length > 0, strength / np.maximum(length, 1) / STRONGEST, 0.5).astype(np.float32)
