"""The true surface: even, named, and visible where a camera sees it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import open3d as o3d
import pytest

from data_tools.synthetic.camera.hand_held import walk_round
from data_tools.synthetic.rendering.ray_renderer import scene_of
from data_tools.synthetic.scenes.living_room import living_room
from data_tools.synthetic.shapes.solids import box
from data_tools.synthetic.shapes.thing import Thing, tinted
from data_tools.synthetic.synthetic_room import SyntheticRoom
from data_tools.synthetic.truth import tessellation
from data_tools.synthetic.truth.tessellation import affordable_spacing_m, tessellate
from data_tools.synthetic.truth.true_surface import ground_truth
from data_tools.synthetic.truth.visibility import TOLERANCE_M, CameraView, Viewpoint
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.truth_folder import read_truth, write_truth
from razer.errors import BadInput
from razer.frame import Intrinsics
from razer.geometry import inverse
from tests.support.frames import world_points

GREY = tinted("plaster", (200.0, 200.0, 200.0))


@pytest.fixture(scope="module")
def room() -> SyntheticRoom:
    return SyntheticRoom(0, n_frames=40, width=160, height=120)


@pytest.fixture(scope="module")
def truth(room: SyntheticRoom) -> GroundTruth:
    return room.truth(spacing_m=0.05)


def test_a_large_world_has_vertices_as_far_apart_as_can_be_afforded(monkeypatch: pytest.MonkeyPatch) -> None:
    things = {4: Thing("hall", (box((0, 0, 0), (40, 30, 20), GREY),))}
    monkeypatch.setattr(tessellation, "MOST_VERTICES", 20_000)
    spacing_m = affordable_spacing_m(things, 0.01)
    assert 18_000 < len(tessellate(things, spacing_m).vertices) < 22_000
    assert affordable_spacing_m(things, 0.6) == 0.6


def test_truth_covers_the_surface_evenly() -> None:
    things = {4: Thing("box", (box((0, 0, 0), (0.4, 0.3, 0.2), GREY),))}
    surface = tessellate(things, 0.01)
    a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert area == pytest.approx(2 * (0.12 + 0.08 + 0.06))
    longest = max(np.linalg.norm(p - q, axis=1).max() for p, q in ((a, b), (b, c), (c, a)))
    assert longest <= 0.01 * np.sqrt(2) + 1e-9
    # Corners and edges are shared, so that no place counts twice.
    assert len(surface.vertices) == 41 * 31 * 21 - 39 * 29 * 19
    assert len(np.unique(np.rint(surface.vertices * 1e4), axis=0)) == len(surface.vertices)


def test_truth_names_the_classes_of_the_room(room: SyntheticRoom, truth: GroundTruth) -> None:
    assert truth.instance_classes == room.classes
    seen = {int(i) for frame in map(room.__getitem__, range(40)) for i in np.unique(frame.instance_ids)}
    assert seen <= set(truth.instance_classes)
    # So few frames only glimpse the ceiling.
    assert set(np.unique(truth.instances[truth.visible])) >= set(truth.instance_classes) - {2}


def test_pixels_lie_on_truth_of_the_same_instance(room: SyntheticRoom, truth: GroundTruth) -> None:
    frame = room[7]
    points = world_points(frame).reshape(-1, 3)[::41]
    ids = frame.instance_ids.ravel()[::41]
    for point, number in zip(points, ids, strict=True):
        nearest = np.linalg.norm(truth.vertices[truth.instances == number] - point, axis=1).min()
        assert nearest < 0.05


def test_visible_equals_a_look_at_every_vertex() -> None:
    things = living_room(5).things
    camera = Intrinsics(160, 120, 131.0, 131.0, 79.5, 59.5)
    poses = list(walk_round(240, (1.75, 1.3), 5)[100:150:5])
    scene = scene_of(things)
    view = CameraView(camera, (0.1, 2.8))
    found = ground_truth(things, [Viewpoint(p, scene) for p in poses], view, 0.2, {9: 5})
    surface = tessellate(things, 0.2)
    counts = np.zeros(len(surface.vertices), int)
    for number, pose in enumerate(poses):
        for vertex, (point, normal) in enumerate(zip(surface.vertices, surface.normals, strict=True)):
            x, y, z = inverse(pose)[:3, :3] @ point + inverse(pose)[:3, 3]
            if not 0.1 <= z <= 2.8 or normal @ (pose[:3, 3] - point) <= 0:
                continue
            u, v = 131 * x / z + 79.5, 131 * y / z + 59.5
            if not (-0.5 < u < 159.5 and -0.5 < v < 119.5) or (surface.instances[vertex] == 9 and number < 5):
                continue
            direction = (point - pose[:3, 3]) / np.linalg.norm(point - pose[:3, 3])
            ray = np.concatenate([pose[:3, 3], direction])[None].astype(np.float32)
            reach = float(scene.cast_rays(o3d.core.Tensor(ray))["t_hit"].numpy()[0])
            counts[vertex] += reach >= np.linalg.norm(point - pose[:3, 3]) - TOLERANCE_M
    different = found.visible != (counts >= 3)
    assert found.visible.sum() > 200
    # Single precision decides ties on borders differently.
    assert different.sum() <= 3


def test_a_wall_behind_a_thin_poster_is_hidden() -> None:
    """No map can give both sides of what is nine millimetres thick: the wall there is no truth to be found."""
    wall = Thing("wall", (box((-1, 1.0, -1), (1, 1.1, 1), GREY),))
    poster = Thing("poster", (box((-0.5, 0.991, -0.5), (0.5, 1.0, 0.5), GREY),))
    things, looks_along_y = {1: wall, 2: poster}, np.eye(4)
    looks_along_y[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
    viewpoints = [Viewpoint(looks_along_y, scene_of(things))] * 3
    view = CameraView(Intrinsics(160, 120, 131.0, 131.0, 79.5, 59.5), (0.1, 2.8))
    truth = ground_truth(things, viewpoints, view, 0.05)
    across = np.abs(truth.vertices[:, [0, 2]])
    front = truth.visible & (np.abs(truth.vertices[:, 1] - 1.0) < 1e-3) & (truth.instances == 1)
    assert front.sum() > 50
    assert across[front].max(axis=1).min() > 0.49
    assert truth.visible[truth.instances == 2].sum() > 300


def test_truth_round_trip(truth: GroundTruth, tmp_path: Path) -> None:
    write_truth(truth, tmp_path / "truth")
    back = read_truth(tmp_path / "truth")
    for name in ("vertices", "triangles", "instances", "classes", "visible"):
        assert np.array_equal(getattr(truth, name), getattr(back, name))
    assert back.class_names == truth.class_names
    mesh = tmp_path / "truth" / "mesh.ply"
    mesh.write_bytes(mesh.read_bytes()[:-7])
    with pytest.raises(BadInput, match="cut short"):
        read_truth(tmp_path / "truth")
    mesh.write_bytes(b"ply\nformat ascii 1.0\nend_header\n")
    with pytest.raises(BadInput, match="no vertex property x"):
        read_truth(tmp_path / "truth")
    mesh.unlink()
    with pytest.raises(BadInput, match="missing"):
        read_truth(tmp_path / "truth")
