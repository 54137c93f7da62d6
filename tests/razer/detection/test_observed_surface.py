"""The cells a frame sees, against np.unique, hand-made depth planes and literal loops."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose

from razer.detection.observed_surface import BLOCK, ObservedSurface, cells_of
from razer.errors import UnusableFrame
from razer.frame import Frame, Intrinsics
from tests.support.scenes import CAMERA, COARSE, cells_at, frame_of, look, plane_depth, pose

# At 1 m, neighbouring pixels of this camera are exactly one voxel of 2 cm apart, and pixel (3, 4) looks ahead.
GRID = Intrinsics(8, 6, 50.0, 50.0, 4.0, 3.0)
COORDINATES = arrays(np.int32, st.tuples(st.integers(1, 60), st.just(3)), elements=st.integers(-40, 40))


@given(coordinates=COORDINATES)
@settings(deadline=None, max_examples=100)
def test_cells_are_the_distinct_coordinates(coordinates: np.ndarray) -> None:
    cells, row = cells_of(coordinates, 0.5)
    assert np.array_equal(cells.coordinates[row], coordinates)
    assert len(cells) == len(np.unique(coordinates, axis=0))
    assert_allclose(cells.points, cells.coordinates * 0.5)


@given(coordinates=COORDINATES)
@settings(deadline=None, max_examples=50)
def test_cells_are_ordered_by_block_and_place_whatever_the_order_given(coordinates: np.ndarray) -> None:
    cells, _ = cells_of(coordinates, 0.5)
    x, y, z = (coordinates % BLOCK).T
    local = x + BLOCK * y + BLOCK**2 * z
    expected = np.unique(np.column_stack([coordinates // BLOCK, local]), axis=0)
    assert np.array_equal(np.column_stack([cells.block_keys[cells.block], cells.local]), expected)
    assert np.array_equal(cells.block_keys, np.unique(coordinates // BLOCK, axis=0))
    reversed_cells, _ = cells_of(coordinates[::-1].copy(), 0.5)
    assert np.array_equal(reversed_cells.coordinates, cells.coordinates)


def test_no_coordinates_are_no_cells() -> None:
    cells, row = cells_of(np.zeros((0, 3), np.int32), 0.02)
    assert len(cells) == len(row) == 0
    assert cells.points.shape == (0, 3)


def test_surface_of_a_hand_made_wall() -> None:
    surface = ObservedSurface.of(frame_of(np.ones((6, 8)), camera=GRID), 0.02, 0.1, 1.0)
    assert surface.stride == 1
    expected = [[u - 4, v - 3, 50] for v in range(6) for u in range(8)]
    assert np.array_equal(surface.cells.coordinates[surface.pixel_cell], expected)
    assert len(surface.cells) == 48


def test_readings_out_of_range_are_none() -> None:
    depth = np.ones((6, 8))
    depth[0, 0], depth[1, 1], depth[2, 2], depth[3, 3] = 0, 0.05, 1.2, np.nan
    frame = frame_of(depth, camera=GRID)
    surface = ObservedSurface.of(frame, 0.02, 0.1, 1.0)
    assert len(surface.rows) == 44
    assert np.array_equal(np.argwhere(surface.depth == 0), [[0, 0], [1, 1], [2, 2], [3, 3]])
    assert np.array_equal(surface.depth[surface.rows, surface.columns], np.ones(44))


def test_strided_surface_is_made_of_every_other_pixel() -> None:
    fine = Intrinsics(16, 12, 100.0, 100.0, 8.0, 6.0)
    surface = ObservedSurface.of(frame_of(np.ones((12, 16)), camera=fine), 0.02, 0.1, 1.0)
    assert surface.stride == 2
    assert surface.depth.shape == (6, 8)
    expected = [[u - 4, v - 3, 50] for v in range(6) for u in range(8)]
    assert np.array_equal(surface.cells.coordinates[surface.pixel_cell], expected)


def test_cells_follow_the_pose() -> None:
    at = pose((0.4, -0.2, 1.0), (0, 90, 0))  # looks along world x; camera x is world -z
    surface = ObservedSurface.of(frame_of(np.ones((6, 8)), at, camera=GRID), 0.02, 0.1, 1.0)
    expected = [[20 + 50, -10 + v - 3, 50 - (u - 4)] for v in range(6) for u in range(8)]
    assert np.array_equal(surface.cells.coordinates[surface.pixel_cell], expected)


@pytest.mark.parametrize("depth_m", [0.0, 0.01, 9.0])
def test_a_frame_without_depth_in_range_is_unusable(depth_m: float) -> None:
    with pytest.raises(UnusableFrame, match="no depth reading between"):
        look(frame_of(np.full((120, 160), depth_m)))


def test_a_frame_without_a_pose_is_unusable() -> None:
    frame = frame_of(np.ones((6, 8)), camera=GRID)
    with pytest.raises(UnusableFrame, match="no pose"):
        look(Frame(0, 0.0, frame.rgb, frame.depth, GRID))


def tilted_surface() -> ObservedSurface:
    at = pose((0.3, -0.1, 0.2), (5, -20, 3))
    depth = plane_depth(at, (0.1, 0.2, 1.0), 2.0)
    depth[20:40, 30:50] = 0
    return look(frame_of(depth, at))


def test_every_reading_lies_in_its_cell() -> None:
    surface = tilted_surface()
    centres = surface.cells.points[surface.pixel_cell]
    row, column, z, on_image = surface.pixels_of(centres)
    assert on_image.mean() > 0.95  # but for cells across the border
    # A cell's centre is at most half a voxel's diagonal from each reading in it.
    reach_m = COARSE.voxel_size_m * np.sqrt(3) / 2
    pixels = reach_m * CAMERA.fx / z + 1
    near = (np.abs(row - surface.rows) <= pixels) & (np.abs(column - surface.columns) <= pixels)
    assert near[on_image].all()
    assert (np.abs(z - surface.depth[surface.rows, surface.columns]) <= reach_m + 1e-6).all()


def test_pixels_of_the_readings_own_points_are_the_readings() -> None:
    surface = tilted_surface()
    depth = surface.depth[surface.rows, surface.columns].astype(float)
    rays = np.column_stack([surface.columns, surface.rows, np.ones(len(depth))]) @ np.linalg.inv(surface.matrix).T
    world = (rays * depth[:, None]) @ surface.world_from_camera[:3, :3].T + surface.world_from_camera[:3, 3]
    row, column, z, on_image = surface.pixels_of(world)
    assert on_image.all()
    assert np.array_equal(row, surface.rows)
    assert np.array_equal(column, surface.columns)
    assert_allclose(z, depth, atol=1e-6)


@pytest.mark.filterwarnings("error")
def test_points_behind_or_beside_the_camera_are_on_no_pixel() -> None:
    surface = look(frame_of(np.ones((120, 160))))
    points = np.array([[0, 0, -1.0], [0, 0, 0], [3.0, 0, 1], [0, -3.0, 1], [0, 0, 1]])
    row, column, _, on_image = surface.pixels_of(points)
    assert on_image.tolist() == [False, False, False, False, True]
    assert (row[:4] == 0).all()
    assert (column[:4] == 0).all()


def test_readings_in_masks_by_a_literal_loop() -> None:
    surface = tilted_surface()
    masks = np.random.default_rng(0).random((3, *surface.depth.shape)) < 0.3
    expected = [
        (n, i)
        for n, mask in enumerate(masks)
        for i, (r, c) in enumerate(zip(surface.rows, surface.columns, strict=True))
        if mask[r, c]
    ]
    mask_of, reading = surface.readings_in(masks)
    assert list(zip(mask_of.tolist(), reading.tolist(), strict=True)) == expected


def test_cells_at_block_borders_keep_their_coordinates() -> None:
    corners = [[x, y, z] for x in (-17, -16, -1, 0, 15, 16) for y in (-1, 0) for z in (15, 16)]
    assert sorted(map(tuple, cells_at(corners).coordinates)) == sorted(map(tuple, corners))
