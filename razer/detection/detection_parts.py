"""What a mask becomes besides one detection of its cells, in the paper's way: clusters as detections, moments of
readings, boxes about centroids (RAZER section IV-B)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from razer.arrays import Float64Array, Int32Array
from razer.boxes.oriented_box import OrientedBox, PointMoments
from razer.config import LiftingSettings
from razer.detection.observed_surface import ObservedSurface
from razer.geometry import back_project, transform_points


def cluster_parts(
    surface: ObservedSurface, pixels: Int32Array, labels: Int32Array
) -> Iterator[tuple[Int32Array, Int32Array]]:
    """Cells (n,) and readings (p,) of each DBSCAN cluster of a mask's readings (P,) with their labels (P,), -1 = noise;
    the cluster with most readings first."""
    sizes = np.bincount(labels[labels >= 0])
    for label in np.argsort(-sizes, kind="stable")[: np.count_nonzero(sizes)]:
        part = pixels[labels == label]
        yield np.unique(surface.pixel_cell[part]), part


def fit_box(
    surface: ObservedSurface, cells: Int32Array, pixels: Int32Array, lifting: LiftingSettings
) -> tuple[PointMoments, OrientedBox]:
    """Moments (RAZER eqs. 4 and 5) and box (RAZER eq. 6) of a detection's cells (n,), or of its readings (p,)."""
    points = surface.cells.points[cells] if lifting.points == "cells" else _readings(surface, pixels)
    moments = PointMoments.of(points)
    box = OrientedBox.around(points, moments.axes)
    if lifting.box_center == "centroid":
        box = OrientedBox(moments.mean, box.rotation, box.extent)
    return moments, box


def _readings(surface: ObservedSurface, pixels: Int32Array) -> Float64Array:
    """World points (p, 3) of readings (RAZER eq. 3)."""
    rows, columns = surface.rows[pixels], surface.columns[pixels]
    points = back_project(columns, rows, surface.depth[rows, columns], surface.matrix)
    return transform_points(surface.world_from_camera, points).astype(np.float64, copy=False)
