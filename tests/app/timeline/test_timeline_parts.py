"""What the timeline is made of: chunks of the map, thinned points, small meshes, viewpoints, the viewer."""

from __future__ import annotations

import socket
from itertools import pairwise
from math import log

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.render.mesh_decimation import cluster_vertices, decimated
from app.render.viewpoint import behind, overview
from app.timeline import viewer
from app.timeline.images import every_nth, scaled_to
from app.timeline.map_chunks import Chunk, ChunkSchedule, by_chunk, thinned
from razer.errors import BadInput
from razer.frame import Intrinsics
from razer.geometry import project
from razer.mesh.labelled_mesh import LabelledMesh
from razer.volume.mesh_extraction import SurfacePoints

VOXEL_M = 0.02
BLOCK_M = 16 * VOXEL_M
CHUNK_M = 4 * BLOCK_M


def voxel_points(seed: int, n: int = 3000) -> SurfacePoints:
    rng = np.random.default_rng(seed)
    lattice = np.unique(rng.integers(-150, 150, (n, 3)), axis=0)
    rgb = rng.integers(0, 255, (len(lattice), 3)).astype(np.uint8)
    return SurfacePoints((lattice * VOXEL_M).astype(np.float32), rgb, np.arange(len(lattice), dtype=np.int32))


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


def test_chunk_knows_its_blocks():
    keys = Chunk(-1, 0, 2).block_keys
    assert len(np.unique(keys, axis=0)) == 64
    assert keys.min(axis=0).tolist() == [-4, 0, 8]
    assert keys.max(axis=0).tolist() == [-1, 3, 11]


@pytest.mark.parametrize("seed", range(3))
def test_points_are_parted_by_chunk(seed):
    points = voxel_points(seed)
    parts = by_chunk(points, VOXEL_M)
    assert sorted(np.concatenate(list(parts.values()))) == list(range(len(points.positions)))
    for chunk, rows in parts.items():
        inside = points.positions[rows] + VOXEL_M / 2 - np.array(chunk) * CHUNK_M
        assert (inside > 0).all()
        assert (inside < CHUNK_M).all()
        blocks = set(map(tuple, np.floor((points.positions[rows] + 1e-4) / BLOCK_M).astype(int)))
        assert blocks <= set(map(tuple, chunk.block_keys.tolist()))


def test_no_points_are_in_no_chunk():
    points = voxel_points(0, n=1)
    nothing = SurfacePoints(points.positions[:0], points.colors[:0], points.instances[:0])
    assert by_chunk(nothing, VOXEL_M) == {}


@pytest.mark.parametrize("keep_one_of", [1, 2, 6])
def test_thinning_keeps_its_share_and_does_not_depend_on_the_neighbours(keep_one_of):
    points = voxel_points(5)
    kept = thinned(points, VOXEL_M, keep_one_of)
    expected = len(points.positions) / keep_one_of
    assert abs(len(kept.positions) - expected) <= 5 * np.sqrt(expected)
    half = slice(0, len(points.positions) // 2)
    part = SurfacePoints(points.positions[half], points.colors[half], points.instances[half])
    assert set(thinned(part, VOXEL_M, keep_one_of).instances) == set(kept.instances) & set(part.instances)


def test_thinning_leaves_no_plane_empty():
    x, y = np.meshgrid(np.arange(64), np.arange(64))
    for normal in np.eye(3, dtype=int):
        axes = [axis for axis in range(3) if not normal[axis]]
        lattice = np.zeros((64 * 64, 3))
        lattice[:, axes[0]], lattice[:, axes[1]] = x.ravel(), y.ravel()
        size = len(lattice)
        flat = SurfacePoints(
            (lattice * VOXEL_M).astype(np.float32), np.zeros((size, 3), np.uint8), np.arange(size, dtype=np.int32)
        )
        assert 0.1 < len(thinned(flat, VOXEL_M, 6).positions) / size < 0.23


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


def test_missing_recording_is_bad_input(tmp_path):
    with pytest.raises(BadInput, match="does not exist"):
        viewer.open_viewer(tmp_path / "timeline.rrd", web=True)


def test_taken_port_is_replaced():
    with socket.socket() as taken:
        taken.bind((viewer.HOST, 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert viewer._free_port(port) != port


def test_failing_viewer_is_bad_input_and_a_good_one_is_not(tmp_path, monkeypatch):
    (tmp_path / "timeline.rrd").touch()
    commands = []
    monkeypatch.setattr(viewer, "_run_until_stopped", lambda command: commands.append(command) or len(commands) - 1)
    viewer.open_viewer(tmp_path / "timeline.rrd", web=False)
    with pytest.raises(BadInput, match="--web"):
        viewer.open_viewer(tmp_path / "timeline.rrd", web=False)
    assert viewer.VIEWER_MEMORY in commands[0]
