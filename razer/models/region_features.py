"""What is known of each image region and of each border between two: colour, place, size, strength."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.frame import Intrinsics
from razer.models.local_planes import Image, LocalPlanes
from razer.models.region_graph import RegionGraph
from razer.models.surface_edges import STRONGEST

# Columns of RegionGraph.sums (Lab units, metres, square metres) and RegionGraph.boundary.
COUNT, LIGHT, RED_GREEN, YELLOW_BLUE, X, Y, Z, SQUARE, AREA = range(9)
LENGTH, STRENGTH, GAP = range(3)

_EVERY = 2  # means over a region need only every second pixel in each direction
_MAX_GAP_M = 0.3
_FULL_COLOUR_DIFFERENCE = 30.0  # Lab units
_LIGHT_WEIGHT = 0.3  # light falls unevenly: lightness says less than hue


def region_graph(
    labels: NDArray[np.int32],
    n: int,
    planes: LocalPlanes,
    borders: tuple[Image, Image],
    rgb: NDArray[np.uint8],
    camera: Intrinsics,
) -> RegionGraph:
    """The graph of n regions in an (h, w) label image (-1 = nobody), with the columns named above; borders as
    from edge_strengths, rgb (H, W, 3) at any resolution, camera that of the label image."""
    depth = np.where(planes.valid, 1 / np.maximum(planes.value, np.float32(0.05)), 0)
    sides = []
    for axis, strength in zip((1, 0), borders, strict=True):
        gap = np.minimum(np.abs(np.diff(depth, axis=axis, append=0)), np.float32(_MAX_GAP_M))
        across = np.ones((1, 3) if axis == 1 else (3, 1), np.uint8)
        # The border drawn may lie a pixel beside the edge: the strongest of three counts.
        sides.append(np.stack([np.ones_like(gap), cv2.dilate(strength, across), cv2.dilate(gap, across)]))
    return RegionGraph.of(np.where(planes.valid, labels, -1), n, _pixels(depth, rgb, camera), sides, _EVERY)


def _pixels(depth: Image, rgb: NDArray[np.uint8], camera: Intrinsics) -> Image:
    z = depth[::_EVERY, ::_EVERY]
    small = cv2.resize(rgb, z.shape[::-1], interpolation=cv2.INTER_AREA)
    lab = cv2.cvtColor(small, cv2.COLOR_RGB2LAB).astype(np.float32).transpose(2, 0, 1)
    u = np.arange(0, depth.shape[1], _EVERY, dtype=np.float32)
    v = np.arange(0, depth.shape[0], _EVERY, dtype=np.float32)[:, None]
    x = z * (u - np.float32(camera.cx)) / np.float32(camera.fx)
    y = z * (v - np.float32(camera.cy)) / np.float32(camera.fy)
    area = z * z * np.float32(_EVERY**2 / (camera.fx * camera.fy))
    return np.stack([np.full_like(z, _EVERY**2), *lab, x, y, z, x * x + y * y + z * z, area])


def colour_difference(graph: RegionGraph) -> NDArray[np.float64]:
    """Difference of mean colour of the two regions of each pair (E,), in [0, 1]."""
    samples = np.maximum(graph.sums[:, COUNT], 1) / _EVERY**2
    colour = graph.sums[:, [LIGHT, RED_GREEN, YELLOW_BLUE]] / samples[:, None]
    light, red_green, yellow_blue = np.abs(colour[graph.pairs[:, 0]] - colour[graph.pairs[:, 1]]).T
    return np.clip((np.hypot(red_green, yellow_blue) + _LIGHT_WEIGHT * light) / _FULL_COLOUR_DIFFERENCE, 0, 1)


def size_m(sums: NDArray[np.float64]) -> NDArray[np.float64]:
    """Length (N,) of the straight rod with the same scatter as each row's points, metres."""
    samples = np.maximum(sums[:, COUNT], 1) / _EVERY**2
    mean = sums[:, [X, Y, Z]] / samples[:, None]
    return np.sqrt(12 * np.maximum(sums[:, SQUARE] / samples - (mean**2).sum(axis=1), 0))


def distinctness(graph: RegionGraph) -> NDArray[np.float32]:
    """Mean strength (N,) of each region's border to its neighbours, in [0, 1]; 0.5 where it has none."""
    length, strength = (
        sum(np.bincount(graph.pairs[:, side], graph.boundary[:, column], len(graph.sums)) for side in (0, 1))
        for column in (LENGTH, STRENGTH)
    )
    return np.where(length > 0, strength / np.maximum(length, 1) / STRONGEST, 0.5).astype(np.float32)
