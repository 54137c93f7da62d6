"""Class-agnostic geometric segmentation: convexity-based region merging of a depth image, without weights."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import ClassVar

import cv2
import numpy as np

from razer.arrays import Float64Array, Int32Array
from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models.geometric.local_planes import fit_local_planes, inverse_depth
from razer.models.geometric.oversegmentation import oversegment
from razer.models.geometric.region_features import (
    AREA,
    GAP,
    LENGTH,
    PLANE,
    STRENGTH,
    colour_difference,
    distinctness,
    region_graph,
    size_m,
)
from razer.models.geometric.region_graph import RegionGraph
from razer.models.geometric.region_planes import plane_misfit
from razer.models.geometric.surface_edges import EdgeLimits, edge_strengths

_WORKING_WIDTH = 320  # pixels; what is given in pixels elsewhere is meant for an image about this wide
_POSITIVE = ("noise_per_m", "step", "concave_deg", "convex_deg")
_COPLANAR = 2.0  # standard deviations of the noise up to which two regions are coplanar
_COPLANAR_BONUS = 0.8
_PART_GAP_M = 0.13  # largest depth gap between parts of one object
_SLIVER_M2 = 0.002  # a region with less surface may join an object up to the next size
_SLIVER_HOST_M = 0.6
_SLIVER_GROWTH = 1.15  # but must not enlarge it by more


@dataclass(frozen=True)
class GeometricSegmenter:
    """Masks bounded by depth steps and concave creases, refined by colour; they do not overlap.

    That convex surfaces belong together is the idea of Tateno (2015) and Furrer (2018); here regions are merged
    by the mean strength of their common border, so that one weak pixel joins nothing.

    Args:
        noise_per_m: standard deviation of inverse depth, 1/m (Kinect: 0.0013 and some for unevenness). Larger: fewer
            and coarser masks.
        step: depth step that separates regions, in noise_per_m. Lower: more and smaller masks.
        concave_deg: concave crease that separates regions, degrees. Lower: more and smaller masks.
        convex_deg: convex crease that separates regions, degrees. Lower: more and smaller masks.
        colour_weight: what a full colour difference adds to the strength of a border, which separates from 1 on.
        piece_m: adjacent regions that together have no longer diagonal, metres, are one object, like a cup's inside
            and outside. Larger: clutter is merged.
        min_pixels: smaller masks are left out, at 640x480.

    Raises:
        BadInput: for impossible values.
    """

    noise_per_m: float = 0.0016
    step: float = 2.5
    concave_deg: float = 18.0
    convex_deg: float = 100.0
    colour_weight: float = 0.3
    piece_m: float = 0.2
    min_pixels: int = 200

    prefers_fused_surface: ClassVar[bool] = True

    def __post_init__(self) -> None:
        for option in fields(self):
            value = getattr(self, option.name)
            if not np.isfinite(value) or value < 0 or (value == 0 and option.name in _POSITIVE):
                raise BadInput(f"segmenter option {option.name} must be a positive number, not {value}")

    def segment(self, frame: Frame) -> Masks:
        """The masks of one frame, each with the mean strength of its border as score."""
        height, width = frame.depth.shape
        inverse = inverse_depth(frame.depth, max(1, round(width / _WORKING_WIDTH)), self.noise_per_m)
        planes = fit_local_planes(inverse, self.noise_per_m)
        camera = frame.intrinsics.resized(inverse.shape[1], inverse.shape[0])
        limits = EdgeLimits(self.noise_per_m, self.step, self.concave_deg, self.convex_deg)
        borders = edge_strengths(planes, camera, limits)
        labels, n = oversegment(np.maximum(*borders), planes.valid)
        if n == 0:
            return Masks.none(height, width)
        graph = region_graph(labels, n, planes, borders, frame.rgb, camera)
        return self._masks(graph.merged(self._border_cost).merged(self._part_cost), labels, (height, width))

    def _border_cost(self, graph: RegionGraph) -> Float64Array:
        """Mean strength of the common border; a colour difference adds to it, coplanarity subtracts from it."""
        strength = graph.boundary[:, STRENGTH] / graph.boundary[:, LENGTH]
        misfit = plane_misfit(graph.sums[:, PLANE], graph.pairs) / self.noise_per_m
        coplanarity = np.clip(2 - misfit / _COPLANAR, 0, 1)
        return strength + self.colour_weight * colour_difference(graph) - _COPLANAR_BONUS * coplanarity

    def _part_cost(self, graph: RegionGraph) -> Float64Array:
        """Depth gap between two regions that may be parts of one small object, and colour difference."""
        size, (a, b) = size_m(graph.sums), graph.pairs.T
        joint, larger = size_m(graph.sums[a] + graph.sums[b]), np.maximum(size[a], size[b])
        is_sliver = np.minimum(graph.sums[a, AREA], graph.sums[b, AREA]) < _SLIVER_M2
        is_sliver &= (larger < _SLIVER_HOST_M) & (joint < _SLIVER_GROWTH * larger)
        gap = graph.boundary[:, GAP] / graph.boundary[:, LENGTH] / _PART_GAP_M
        cost = gap + self.colour_weight * colour_difference(graph)
        return np.where((joint < self.piece_m) | is_sliver, cost, np.inf)

    def _masks(self, graph: RegionGraph, labels: Int32Array, shape: tuple[int, int]) -> Masks:
        """The regions that are large enough, in the order of their first pixels, at full size."""
        region = np.append(graph.region, len(graph.region))[labels]  # -1 = unlabelled becomes the last
        pixels = np.bincount(region.ravel(), minlength=len(graph.region) + 1)[:-1]
        kept = np.flatnonzero(pixels / labels.size >= self.min_pixels / (640 * 480))
        number = np.zeros(len(pixels) + 1, np.uint16)
        number[kept] = np.arange(1, len(kept) + 1)
        ids = cv2.resize(number[region], shape[::-1], interpolation=cv2.INTER_NEAREST)
        stack = ids[None] == np.arange(1, len(kept) + 1, dtype=np.uint16)[:, None, None]
        return Masks(stack, distinctness(graph)[kept])
