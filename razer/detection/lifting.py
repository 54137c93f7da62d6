"""Lifting of masks to 3D detections: back-projection, DBSCAN, box fit by PCA (RAZER section IV-B)."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from razer.arrays import BoolArray, Float32Array, Float64Array, IndexArray, Int32Array
from razer.boxes.oriented_box import OrientedBox, PointMoments
from razer.config import LiftingSettings, MaskSettings
from razer.detection.background_filter import background_limit_m
from razer.detection.best_views import Region
from razer.detection.dbscan import cluster
from razer.detection.detection_parts import cluster_parts, fit_box
from razer.detection.observed_surface import ObservedSurface
from razer.detection.view_sector import view_sector
from razer.frame import Frame, Masks

REFERENCE_PIXELS = 640 * 480
CUT_DOUBT = 0.75  # how much less a view is trusted that the image border cuts all around


@dataclass(frozen=True)
class Detection:
    """One cluster of one mask: mask, index into the frame's masks; cells (n,), rows of the observed cells;
    pixels (p,), indices of the observed surface's readings; quality in [0, 1], how far its embedding is to be trusted;
    region, where the image shows it, None where that is not known; sector, from which side it is seen
    (`razer.detection.view_sector`)."""

    mask: int
    cells: Int32Array
    pixels: Int32Array
    moments: PointMoments
    box: OrientedBox
    embedding: Float32Array
    score: float
    quality: float
    class_name: str | None
    region: Region | None = None
    is_stuff: bool = False
    sector: int = 0

    @property
    def n_cells(self) -> int:
        """Occupied cells of the map's voxel size."""
        return len(self.cells)


@dataclass(frozen=True)
class Lifted:
    """The detections of one frame, ordered by mask and then by size, largest first; and all M pairs of a mask and a
    cell before its background: member_mask (M,), member_cell (M,). Where each cluster is a detection, they hold noise
    and small clusters as well, which are in none."""

    detections: tuple[Detection, ...]
    member_mask: Int32Array
    member_cell: Int32Array


def filter_masks(frame: Frame, masks: Masks, settings: MaskSettings) -> Masks:
    """The masks with enough pixels, score and depth readings (docs/method.md step 3)."""
    if len(masks) == 0:
        return masks
    # Areas are counted on every second pixel: exact enough for a threshold, and four times cheaper.
    sparse = masks.masks[:, ::2, ::2].reshape(len(masks), -1)
    area = np.maximum(np.count_nonzero(sparse, axis=1), 1)
    valid = np.count_nonzero(sparse & (frame.depth[::2, ::2] > 0).ravel(), axis=1) / area
    scale = frame.depth.size / REFERENCE_PIXELS
    keep = (area * 4 >= settings.min_pixels * scale) & (masks.scores >= settings.min_score)
    keep &= valid >= settings.min_valid_depth
    return masks if keep.all() else masks.select(keep)


def shrink(masks: BoolArray, pixels: int) -> BoolArray:
    """Each of (N, H, W) masks without its outermost pixels; the image border is no mask border."""
    if pixels < 1 or masks.size == 0:
        return masks
    kernel = np.ones((2 * pixels + 1, 2 * pixels + 1), np.uint8)
    shrunk = np.zeros_like(masks)
    for source, target in zip(masks.view(np.uint8), shrunk.view(np.uint8), strict=True):
        rows = np.flatnonzero(source.any(axis=1))
        if len(rows):
            part = slice(rows[0], rows[-1] + 1)
            border = cv2.copyMakeBorder(source[part], 1, 1, 0, 0, cv2.BORDER_CONSTANT, value=0)
            border[0], border[-1] = rows[0] == 0, rows[-1] == len(source) - 1
            target[part] = cv2.erode(border, kernel, borderValue=1)[1:-1]
    return shrunk


def lift(
    surface: ObservedSurface, masks: Masks, embeddings: Float32Array, lifting: LiftingSettings, shrink_pixels: int
) -> Lifted:
    """Back-project the shrunk masks (RAZER eq. 3), take off their background by DBSCAN, and fit boxes (RAZER eqs. 4
    to 6).

    Args:
        surface: The depth readings of the frame and the voxel cells they fall in.
        masks: N instance masks (N, H, W) of the same frame.
        embeddings: A vector of unit length for each, (N, D).
        lifting: Thresholds of clustering and of what counts as a detection.
        shrink_pixels: Pixels taken off each mask's border, at 640x480.
    """
    if len(masks) == 0 or len(surface.cells) == 0:
        return Lifted((), np.zeros(0, np.int32), np.zeros(0, np.int32))
    height = masks.masks.shape[1]
    strided = np.ascontiguousarray(masks.masks[:, :: surface.stride, :: surface.stride])
    strided = shrink(strided, round(shrink_pixels * height / 480 / surface.stride))
    mask_of, pixel_of = surface.readings_in(strided)
    clusters = find_clusters(surface, len(masks), mask_of, pixel_of, lifting)
    depth_m = surface.depth[surface.rows[pixel_of], surface.columns[pixel_of]]
    limits_m = mask_limits_m(surface, len(masks), depth_m, clusters, lifting)
    limits_m[masks.is_stuff & (limits_m > 0)] = np.inf  # a floor goes on behind the door
    kept = depth_m <= limits_m[mask_of]
    pixel_counts = np.bincount(mask_of, minlength=len(masks))
    mask_of, pixel_of, labels = mask_of[kept], pixel_of[kept], clusters.labels_of_readings[kept]
    member_mask, member_cell, _ = occupied_cells(surface, len(masks), mask_of, pixel_of)
    detections = []
    for mask in np.unique(member_mask).tolist():
        of_mask = mask_of == mask
        pixels = pixel_of[of_mask].astype(np.int32)
        whole = (member_cell[member_mask == mask], pixels)
        parts = [whole] if lifting.detections == "mask" else cluster_parts(surface, pixels, labels[of_mask])
        detections += [
            _detection(surface, masks, embeddings, mask, cells, part, len(part) / pixel_counts[mask], lifting)
            for cells, part in parts
            if len(cells) >= lifting.min_cells
        ]
    return Lifted(tuple(detections), member_mask, member_cell)


@dataclass(frozen=True)
class MaskClusters:
    """DBSCAN's labels, -1 = noise, no label in two masks: labels (M,) of M pairs of a mask and a cell it covers,
    mask (M,), cell (M,); labels_of_readings (P,) of the readings in masks."""

    mask: Int32Array
    cell: Int32Array
    labels: Int32Array
    labels_of_readings: Int32Array


def find_clusters(
    surface: ObservedSurface, n_masks: int, mask_of: IndexArray, pixel_of: Int32Array, lifting: LiftingSettings
) -> MaskClusters:
    """The clusters of the cells that readings (P,) of each mask lie in."""
    mask, cell, member_of_reading = occupied_cells(surface, n_masks, mask_of, pixel_of)
    radius = max(lifting.dbscan_eps_m / surface.cells.voxel_size_m, 2.0)
    labels = cluster(surface.cells, mask, cell, radius, lifting.dbscan_min_points)
    return MaskClusters(mask, cell, labels, labels[member_of_reading])


def mask_limits_m(
    surface: ObservedSurface, n_masks: int, depth_m: Float32Array, clusters: MaskClusters, lifting: LiftingSettings
) -> Float64Array:
    """The depth (N,) to which readings of each of N masks are of the thing, and not of what is seen behind it; 0 for
    masks without a cluster of `min_cells`, which keep none. `depth_m` (P,) is that of the readings in masks, metres."""
    members, readings = _rows_by_label(clusters.labels), _rows_by_label(clusters.labels_of_readings)
    labels_of: dict[int, list[int]] = defaultdict(list)
    for label, rows in members.items():
        if label >= 0 and len(rows) >= lifting.min_cells:
            labels_of[int(clusters.mask[rows[0]])].append(label)
    limits_m = np.zeros(n_masks)
    for mask, labels in labels_of.items():
        depths_m = [depth_m[readings[label]] for label in labels]
        points = [surface.cells.points[clusters.cell[members[label]]] for label in labels]
        limits_m[mask] = background_limit_m(depths_m, points, lifting.background_gap_m)
    return limits_m if lifting.drop_background else np.where(limits_m > 0, np.inf, 0.0)


def _rows_by_label(labels: Int32Array) -> dict[int, IndexArray]:
    """The rows of each label of (N,)."""
    order = np.argsort(labels, kind="stable")
    values, starts = np.unique(labels[order], return_index=True)
    ends = np.append(starts[1:], len(labels))
    return {int(v): order[start:end] for v, start, end in zip(values, starts, ends, strict=False)}


def _detection(
    surface: ObservedSurface,
    masks: Masks,
    embeddings: Float32Array,
    mask: int,
    cells: Int32Array,
    pixels: Int32Array,
    share: float,
    lifting: LiftingSettings,
) -> Detection:
    """The detection of a part of a mask, which holds this share of the mask's readings."""
    moments, box = fit_box(surface, cells, pixels, lifting)
    score = float(masks.scores[mask])
    rows, columns = surface.rows[pixels], surface.columns[pixels]
    cut = cut_share(rows, columns, surface.extent)
    return Detection(
        mask=mask,
        cells=cells,
        pixels=pixels,
        moments=moments,
        box=box,
        embedding=embeddings[mask],
        score=score,
        quality=view_quality(score, share, len(pixels) * surface.stride**2, cut),
        class_name=None if masks.class_names is None else masks.class_names[mask] or None,
        region=Region.of(rows, columns, surface.depth.shape, surface.stride),
        is_stuff=bool(masks.is_stuff[mask]),
        sector=view_sector(moments.mean, surface.world_from_camera[:3, 3]),
    )


def occupied_cells(
    surface: ObservedSurface, n_sets: int, set_of: NDArray, pixel_of: NDArray
) -> tuple[Int32Array, Int32Array, Int32Array]:
    """The distinct (set, cell) pairs of readings in sets, sorted by cell, and the pair of each of the readings.

    Args:
        surface: The readings and their cells.
        n_sets: How many sets there are.
        set_of: The set (P,) of each reading; a reading may be listed once for each of several sets.
        pixel_of: The reading (P,), as an index of the surface's.
    """
    key = surface.pixel_cell[pixel_of].astype(np.int64) * n_sets + set_of
    taken = np.zeros(len(surface.cells) * n_sets, bool)
    taken[key] = True
    members = np.flatnonzero(taken)
    rank = np.zeros(len(taken), np.int32)
    rank[members] = np.arange(len(members), dtype=np.int32)
    return (members % n_sets).astype(np.int32), (members // n_sets).astype(np.int32), rank[key]


def view_quality(score: float, visible_share: float, pixels: int, cut: float = 0.0, enough_pixels: int = 4000) -> float:
    """The confidence c_new in [0, 1] of one observation: the product of all four, pixels saturating.

    Args:
        score: Of the mask, in [0, 1].
        visible_share: Share of the mask's readings that belong to the detection.
        pixels: Their number at full resolution.
        cut: Share of its outline that is the border of the image, beyond which the thing goes on.
        enough_pixels: The number that counts half.
    """
    return score * visible_share * (1 - CUT_DOUBT * cut) * pixels / (pixels + enough_pixels)


def cut_share(rows: Int32Array, columns: Int32Array, extent: tuple[int, int, int, int]) -> float:
    """How much of the outline of readings (P,) is the border of what the depth camera shows, the first and last row and
    column (inclusive) of `extent`, as a share of that of the box around them."""
    top, bottom, left, right = extent
    on_border = sum(np.count_nonzero(at) for at in (rows == top, rows == bottom, columns == left, columns == right))
    outline = 2 * (np.ptp(rows) + np.ptp(columns) + 2)
    return min(1.0, float(on_border / outline))
