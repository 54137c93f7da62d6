"""What the timeline is made of: chunks of the map, small meshes, images, viewpoints."""

from __future__ import annotations

from itertools import pairwise
from math import log

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.render.mesh_decimation import cluster_vertices, decimated
from app.render.palette import instance_colors
from app.render.viewpoint import behind, from_above, overview
from app.timeline.images import every_nth, instance_overlay, scaled_to
from app.timeline.map_chunks import ChunkSchedule
from razer.frame import Intrinsics
from razer.geometry import project
from razer.mesh.labelled_mesh import LabelledMesh
from razer.mesh.mesh_chunks import Chunk

VOXEL_M = 0.02
CHUNK_M = 4 * 16 * VOXEL_M


def grid_mesh(n: int, step_m: float) -> LabelledMesh:
    """A flat square of n x n vertices."""
    x, y = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    vertices = np.stack([x.ravel() * step_m, y.ravel() * step_m, np.zeros(n * n)], 1).astype(np.float32)
    corner = (x * n + y)[:-1, :-1].ravel()
    triangles = np.concatenate(
        [np.stack([corner, corner + n, corner + 1], 1), np.stack([corner + 1, corner + n, corner + n + 1], 1)]
    )
    ids = np.arange(n * n, dtype=np.int32)
    return LabelledMesh(vertices, np.zeros((n * n, 3), np.uint8), ids, triangles.astype(np.int32))


@pytest.mark.parametrize("growth", [1.2, 1.6, 3.0])
def test_chunk_is_drawn_at_once_and_then_ever_more_rarely(growth):
    schedule = ChunkSchedule(growth)
    drawn_at = []
    for n in range(1, 1001):
        schedule.observe(np.array([[-1, 0, 5], [-4, 3, 4]], np.int32))
        if schedule.take_due():
            drawn_at.append(n)
    assert drawn_at[0] == 1
    assert len(drawn_at) <= 1 + log(1000) / log(growth)
    assert all(later >= growth * earlier for earlier, later in pairwise(drawn_at))


def test_only_observed_chunks_are_due():
    schedule = ChunkSchedule(2.0)
    schedule.observe(np.array([[0, 0, 0], [3, 3, 3], [-1, 0, 0]], np.int32))
    assert sorted(schedule.take_due()) == [Chunk(-1, 0, 0), Chunk(0, 0, 0)]
    schedule.observe(np.array([[-2, 1, 1]], np.int32))
    assert schedule.take_due() == [Chunk(-1, 0, 0)]
    schedule.observe(np.zeros((0, 3), np.int32))
    assert schedule.take_due() == []


def test_small_mesh_is_left_alone():
    mesh = grid_mesh(20, 0.02)
    assert decimated(mesh, 400) is mesh


def test_large_mesh_gets_within_the_limit_and_stays_a_square():
    mesh = decimated(grid_mesh(100, 0.02), 1000)
    assert 200 < len(mesh.vertices) <= 1000
    a, b, c = (mesh.vertices[mesh.triangles[:, corner]].astype(float) for corner in range(3))
    doubled_areas = np.cross(b - a, c - a)
    assert (doubled_areas[:, 2] > -1e-9).all()  # no triangle is turned over
    assert doubled_areas[:, 2].sum() / 2 == pytest.approx(1.98**2, rel=0.1)


def test_clustering_keeps_real_vertices_and_drops_collapsed_triangles():
    mesh = grid_mesh(30, 0.02)
    small = cluster_vertices(mesh, 0.05)
    assert (mesh.vertices[small.instances] == small.vertices).all()  # the test's ids are vertex numbers
    assert all(len({*triangle}) == 3 for triangle in small.triangles.tolist())
    assert len(np.unique(np.floor(small.vertices / 0.05), axis=0)) == len(small.vertices)


@given(st.integers(1, 9), st.floats(-0.4, 0.4), st.floats(-0.3, 0.3))
@settings(max_examples=50, deadline=None)
def test_sliced_image_has_the_right_camera(n, x, y):
    camera = Intrinsics(640, 480, 520.0, 510.0, 317.0, 241.0)
    point = np.array([x, y, 1.0])
    u, v, _ = project(point, camera.matrix)
    small_u, small_v, _ = project(point, every_nth(camera, n).matrix)
    assert (small_u * n, small_v * n) == pytest.approx((u, v))
    assert every_nth(camera, n).width == len(range(0, 640, n))


def test_images_only_ever_get_smaller():
    camera = Intrinsics(1280, 720, 900.0, 900.0, 639.5, 359.5)
    assert (scaled_to(camera, 640).width, scaled_to(camera, 640).height) == (640, 360)
    assert scaled_to(camera, 4000) == camera


def test_overview_looks_down_on_the_middle_and_ahead():
    points = np.random.default_rng(1).uniform([-1, -2, 0], [1, 2, 1], (5000, 3))
    points[0] = (100, 100, 100)
    view = overview(points, up=np.array([0, 0, 2.0]), forward=np.array([0, 1.0, -0.2]))
    assert view.target == pytest.approx([0, 0, 0.5], abs=0.1)
    gaze = view.target - view.position
    assert gaze[2] < 0 < gaze[1]
    assert gaze[0] == pytest.approx(0)


def test_overview_of_a_camera_that_looks_straight_up_is_finite():
    points = np.random.default_rng(1).uniform(-1, 1, (100, 3))
    view = overview(points, up=np.array([0, 0, 1.0]), forward=np.array([0, 0, 1.0]))
    assert np.isfinite([view.position, view.target]).all()
    assert view.position[2] > view.target[2]


def test_view_from_behind_a_camera_sees_it_in_front():
    pose = np.eye(4)
    pose[:3, 3] = (1, 2, 3)
    view = behind(pose)
    assert view.up.tolist() == [0, -1, 0]
    assert view.position[2] < 3 < view.target[2]


def test_view_from_above_looks_straight_down_and_has_all_points_in_sight():
    points = np.random.default_rng(2).uniform([-4, -1, 1], [4, 1, 2], (200, 3))
    view = from_above(points, up=np.array([0, 0, 1.0]), forward=np.array([0, 1.0, 0]))
    gaze = (view.target - view.position) / np.linalg.norm(view.target - view.position)
    assert gaze[2] < -0.999
    assert view.up.tolist() == [0, 1, 0]  # what lies ahead is up on the screen
    assert view.position[2] - points[:, 2].max() > 4  # half the extent, at 90 degrees


def test_an_instance_is_outlined_in_its_colour_and_tinted_inside():
    rgb, ids = np.full((40, 60, 3), 100, np.uint8), np.zeros((40, 60), np.int32)
    ids[10:30, 20:40] = 300
    image = instance_overlay(rgb, ids, {})
    color = instance_colors(np.array([300]))[0]
    assert (image[10, 20:40] == color).all()
    assert (image[10:30, 39] == color).all()
    assert (image[20, 30] == (0.65 * 100 + 0.35 * color).astype(np.uint8)).all()
    assert (image[ids == 0] == 100).all()


def test_the_name_of_a_large_instance_is_written():
    rgb, ids = np.full((80, 120, 3), 100, np.uint8), np.ones((80, 120), np.int32)
    assert (instance_overlay(rgb, ids, {1: "chair #1"}) != instance_overlay(rgb, ids, {})).any()


def test_parts_clustered_one_by_one_meet_in_the_same_vertices_at_their_seams():
    mesh = grid_mesh(61, 0.02)  # 1.2 m wide
    whole = cluster_vertices(mesh, 0.07, 0.4)
    seam = np.isclose(whole.vertices[:, 0], 0.4, atol=1e-4)
    assert seam.sum() > 10
    for side in (mesh.vertices[:, 0] < 0.401, mesh.vertices[:, 0] > 0.399):
        inside = side[mesh.triangles].all(axis=1)
        part = cluster_vertices(
            LabelledMesh(mesh.vertices, mesh.colors, mesh.instances, mesh.triangles[inside]), 0.07, 0.4
        )
        alone = cluster_vertices(cut(mesh, side), 0.07, 0.4)
        at_seam = alone.vertices[np.isclose(alone.vertices[:, 0], 0.4, atol=1e-4)]
        assert {*map(tuple, at_seam.tolist())} == {*map(tuple, whole.vertices[seam].tolist())}
        assert len(part.triangles) == len(alone.triangles)


def test_without_seams_parts_need_not_meet():
    """The case that seams are for: a cell across the cut has a vertex on either side."""
    mesh = grid_mesh(61, 0.02)
    ends = [
        cluster_vertices(cut(mesh, side), 0.07).vertices
        for side in (mesh.vertices[:, 0] < 0.401, mesh.vertices[:, 0] > 0.399)
    ]
    assert not {*map(tuple, ends[0].tolist())} & {*map(tuple, ends[1].tolist())}


def cut(mesh: LabelledMesh, kept: np.ndarray) -> LabelledMesh:
    """The triangles whose corners are all kept (V,)."""
    row = np.cumsum(kept) - 1
    triangles = row[mesh.triangles[kept[mesh.triangles].all(axis=1)]].astype(np.int32)
    return LabelledMesh(mesh.vertices[kept], mesh.colors[kept], mesh.instances[kept], triangles)
