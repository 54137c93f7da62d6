"""The paper's own lifting: clusters as detections, moments of readings, boxes about centroids."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from razer.boxes.oriented_box import PointMoments
from razer.config import LiftingSettings
from razer.detection.lifting import Lifted, lift
from razer.frame import Masks
from tests.support.scenes import CAMERA, frame_of, look, unit

LIFTING = LiftingSettings(dbscan_eps_m=0.08, dbscan_min_points=4, min_cells=8)
ROWS, COLUMNS = slice(40, 80), slice(60, 112)  # the plate, and 12 columns of the wall


def lifted(**changes: object) -> Lifted:
    """One mask on a plate at 1.5 m and on the wall beside it, at 2.2 m."""
    depth = np.full((CAMERA.height, CAMERA.width), 2.2)
    depth[40:80, 60:100] = 1.5
    mask = np.zeros((1, *depth.shape), bool)
    mask[0, ROWS, COLUMNS] = True
    settings = LIFTING.model_copy(update=changes)
    return lift(look(frame_of(depth)), Masks(mask, np.ones(1, np.float32)), unit(1, 0)[None], settings, 0)


def test_with_background_a_mask_is_all_that_it_covers() -> None:
    (alone,), (whole,) = lifted().detections, lifted(drop_background=False).detections
    assert len(alone.pixels) == 40 * 40
    assert len(whole.pixels) == 40 * 52


def test_each_cluster_of_a_mask_is_a_detection() -> None:
    plate, wall = lifted(drop_background=False, detections="cluster").detections
    assert (len(plate.pixels), len(wall.pixels)) == (40 * 40, 40 * 12)
    assert plate.box.center[2] == pytest.approx(1.5, abs=0.04)
    assert wall.box.center[2] == pytest.approx(2.2, abs=0.04)
    # The confidence of a cluster's vector is by its share of the mask.
    assert plate.quality == pytest.approx(1600 / 2080 * 1600 / 5600)
    assert len(lifted(detections="cluster").detections) == 1, "background is dropped first"


def test_moments_of_readings_are_those_of_the_points_behind_the_pixels() -> None:
    (found,) = lifted(points="readings").detections
    v, u = np.mgrid[40:80, 60:100]
    x, y = (u - CAMERA.cx) / CAMERA.fx * 1.5, (v - CAMERA.cy) / CAMERA.fy * 1.5
    expected = PointMoments.of(np.stack([x, y, np.full(x.shape, 1.5)], axis=-1).reshape(-1, 3))
    assert found.moments.count == expected.count == 1600
    assert_allclose(found.moments.mean, expected.mean, atol=1e-6)
    assert_allclose(found.moments.scatter, expected.scatter, atol=1e-3)
    assert lifted().detections[0].moments.count < 400


def test_a_box_about_the_centroid_has_the_same_edges() -> None:
    middle, centroid = (lifted(drop_background=False, box_center=c).detections[0] for c in ("extents", "centroid"))
    assert_allclose(centroid.box.center, centroid.moments.mean)
    assert_allclose(centroid.box.extent, middle.box.extent)
    assert np.linalg.norm(centroid.box.center - middle.box.center) > 0.02
