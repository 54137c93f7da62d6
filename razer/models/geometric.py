"""Class-agnostic masks from the shape of what is seen: no weights, no training."""

from __future__ import annotations

from dataclasses import dataclass, fields

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.frame import BadInput, Frame, Masks
from razer.models.local_planes import fit_local_planes, inverse_depth
from razer.models.region_features import (
    AREA,
    COUNT,
    GAP,
    LENGTH,
    STRENGTH,
    colour_difference,
    distinctness,
    region_graph,
    size_m,
)
from razer.models.region_graph import RegionGraph
from razer.models.surface_edges import EdgeLimits, edge_strengths

_WORKING_WIDTH = 320  # windows, gaps and least sizes are in pixels of about this width


@dataclass(frozen=True)
class GeometricSegmenter:
    """Masks from depth steps and concave creases (convexity as in Tateno 2015, Furrer 2018), refined by colour.

    noise_per_m: standard deviation of inverse depth, 1/m (Kinect: 0.0013); larger: fewer and coarser masks.
    step: depth step that parts, in those. concave_deg, convex_deg: creases that part, degrees; lower: more and
    smaller masks. colour_weight: how much a full colour difference (30 Lab units) adds to a border's strength.
    piece_m: touching pieces that together stay below this size, metres, are one thing (a cup's inside and
    outside). min_pixels: smaller masks are left out; at 640x480. Raises BadInput for impossible values."""

    noise_per_m: float = 0.0013
    step: float = 2.5
    concave_deg: float = 15.0
    convex_deg: float = 40.0
    colour_weight: float = 0.3
    piece_m: float = 0.16
    min_pixels: int = 200

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not (np.isfinite(value) and value >= 0) or (value == 0 and entry.name != "colour_weight"):
                raise BadInput(f"segmenter option {entry.name} must be positive, not {value}")

    def segment(self, frame: Frame) -> Masks:
        """The masks of one frame, from top left to bottom right; they do not overlap. Depends on nothing but the frame."""
        height, width = frame.depth.shape
        factor = max(1, round(width / _WORKING_WIDTH))
        inverse = inverse_depth(frame.depth, factor, self.noise_per_m)
        planes = fit_local_planes(inverse, self.noise_per_m)
        camera = frame.intrinsics.resized(inverse.shape[1], inverse.shape[0])
        limits = EdgeLimits(self.noise_per_m, self.step, self.concave_deg, self.convex_deg)
        borders = edge_strengths(planes, camera, limits)
        labels, n = _seeds(np.maximum(*borders), planes.valid)
        if n == 0:
            return Masks.none(height, width)
        graph = region_graph(labels, n, planes, borders, frame.rgb, camera)
        graph = graph.merged(self._border_cost).merged(self._piece_cost)
        return self._masks(graph, labels, (height, width), factor)

    def _border_cost(self, graph: RegionGraph) -> NDArray[np.float64]:
        """Mean strength of the common border, and unlike colours."""
        strength = graph.boundary[:, STRENGTH] / graph.boundary[:, LENGTH]
        return strength + self.colour_weight * colour_difference(graph)

    def _piece_cost(self, graph: RegionGraph) -> NDArray[np.float64]:
        """Depth gap between two pieces, in twentieths of a metre, where both are pieces of one small thing."""
        size = size_m(graph.sums)
        a, b = graph.pairs.T
        joint = size_m(graph.sums[a] + graph.sums[b])
        larger = np.maximum(size[a], size[b])
        sliver = np.minimum(graph.sums[a, AREA], graph.sums[b, AREA]) < 0.002
        small = (joint < self.piece_m) | (sliver & (joint < 1.15 * larger) & (larger < 0.6))
        cost = graph.boundary[:, GAP] / graph.boundary[
            :, LENGTH
        ] / 0.05 + self.colour_weight * colour_difference(graph)
        return np.where(small, cost, np.inf)

    def _masks(
        self, graph: RegionGraph, labels: NDArray[np.int32], shape: tuple[int, int], factor: int
    ) -> Masks:
        count = graph.sums[:, COUNT]
        kept = np.flatnonzero(count >= self.min_pixels * shape[0] * shape[1] / (640 * 480 * factor**2))
        number = np.zeros(len(count) + 1, np.uint16)
        number[kept] = np.arange(1, len(kept) + 1)
        small = number[np.append(graph.region, len(count))][labels]
        ids = cv2.resize(small, (shape[1], shape[0]), interpolation=cv2.INTER_NEAREST)
        return Masks(
            ids[None] == np.arange(1, len(kept) + 1, dtype=np.uint16)[:, None, None],
            distinctness(graph)[kept],
        )


def _seeds(strength: NDArray[np.float32], valid: NDArray[np.bool_]) -> tuple[NDArray[np.int32], int]:
    """Label image (-1 = nobody) of the edge-free regions, grown over the edges to the nearest, and their number."""
    inside = ((strength < 1) & valid).astype(np.uint8)
    n, labels, stats, _ = cv2.connectedComponentsWithStats(inside, connectivity=4)
    kept = stats[:, cv2.CC_STAT_AREA] >= 20
    kept[0] = False
    labels = np.where(kept, np.cumsum(kept), 0).astype(np.int32)[labels]
    distance, nearest = cv2.distanceTransformWithLabels(
        (labels == 0).astype(np.uint8), cv2.DIST_L2, 3, labelType=cv2.DIST_LABEL_PIXEL
    )
    seeds = labels > 0
    label_of = np.zeros(nearest.max() + 1, np.int32)
    label_of[nearest[seeds]] = labels[seeds]
    reach = np.where(valid, 6, 2.5).astype(np.float32)
    return np.where(distance < reach, label_of[nearest], 0) - 1, int(kept.sum())
