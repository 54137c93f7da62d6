"""A walk through a labelled mesh: what it shows, where it leads, and that it keeps out of furniture."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from data_tools.synthetic.camera.rgbd_misalignment import RgbdMisalignment
from data_tools.synthetic.camera.walk import usual_frames, walk
from data_tools.synthetic.mesh_sequence import MeshSequence
from data_tools.synthetic.scans.mesh_renderer import MeshRenderer
from data_tools.synthetic.scans.scan_walk import plan_walk
from data_tools.synthetic.scans.surface import upright_surface
from data_tools.synthetic.scans.upright import upright_from_mesh
from data_tools.truth.ground_truth import GroundTruth
from data_tools.truth.truth_folder import write_truth
from razer.errors import BadInput
from razer.frame import Frame, Intrinsics
from razer.geometry import inverse, project, transform_points
from tests.support.frames import world_points
from tests.support.labelled_meshes import HOLE, HOLE_M, TABLE, WIDTH_M, Z_TO_Y, furnished_room, write_room

FEW = (60, 64, 48)  # frames, width, height
CAMERA = Intrinsics(64, 48, 52.5, 52.5, 31.5, 23.5)


@pytest.fixture(scope="module")
def mesh(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_room(tmp_path_factory.mktemp("scan") / "truth", noise_m=0.003)


@pytest.fixture(scope="module")
def sequence(mesh: Path) -> MeshSequence:
    return MeshSequence(mesh, 0, *FEW)


def turned(truth: GroundTruth, rotation: np.ndarray, shift: tuple = (0, 0, 0)) -> GroundTruth:
    return replace(truth, vertices=(truth.vertices @ rotation.T + shift).astype(np.float32))


def walked(truth: GroundTruth, up: str = "auto", seed: int = 0) -> np.ndarray:
    """The centres (N, 3) of a camera in the frame of the mesh, at 15 frames a second."""
    plan = plan_walk(truth, upright_from_mesh(truth, up), seed)
    poses = inverse(plan.upright_from_mesh) @ walk(plan.stations, usual_frames(plan.stations), seed)
    return poses[:, :3, 3]


def dense(truth: GroundTruth) -> np.ndarray:
    """Points (P, 3) all over the faces, about 2 cm apart."""
    corners = truth.vertices[truth.triangles].astype(float)
    steps = [(i / 6, j / 6, (6 - i - j) / 6) for i in range(7) for j in range(7 - i)]
    return np.concatenate([np.einsum("k,tkc->tc", weights, corners) for weights in steps])


def test_frames_show_the_mesh_where_it_is(sequence: MeshSequence) -> None:
    """Each pixel's point lies on the mesh, and has the instance and about the colour of the nearest vertex."""
    truth = furnished_room(noise_m=0.003)
    vertices, surface = cKDTree(truth.vertices), cKDTree(dense(truth))
    assert sequence.classes == truth.instance_classes
    for index in range(0, 60, 15):
        frame = sequence[index]
        seen = frame.depth > 0
        points = world_points(frame)[seen]
        assert seen.mean() > 0.5
        assert surface.query(points)[0].max() < 0.03
        _, nearest = vertices.query(points)
        assert frame.instance_ids is not None
        assert (frame.instance_ids[seen] == truth.instances[nearest]).mean() > 0.97
        assert truth.colors is not None
        assert np.abs(frame.rgb[seen].astype(int) - truth.colors[nearest]).mean() < 4
        assert (frame.rgb[~seen] == 0).all()
        assert (frame.instance_ids[~seen] == 0).all()


def test_nothing_is_seen_through_a_hole_and_no_back_of_a_wall(sequence: MeshSequence) -> None:
    truth = furnished_room(noise_m=0.003)
    surface = upright_surface(truth, np.eye(4))
    pose = np.eye(4)
    pose[:3, :3] = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # looks along y, upright
    pose[:3, 3] = 0, -0.2, 1.4
    rgb, depth, ids, _ = MeshRenderer(surface, CAMERA, np.eye(4)).render(pose)
    u, v, _ = project(transform_points(inverse(pose), np.array([HOLE])), CAMERA.matrix)
    assert depth[round(v[0]), round(u[0])] == rgb[round(v[0]), round(u[0])].sum() == ids[round(v[0]), round(u[0])] == 0
    radius_px = CAMERA.fx * HOLE_M / (WIDTH_M / 2 + 0.2)
    assert (depth == 0).sum() == pytest.approx(np.pi * radius_px**2, rel=0.3)
    pose[1, 3] = -WIDTH_M / 2 - 1.5  # outside, before the back of a wall that hides the room
    rgb, depth, ids, _ = MeshRenderer(surface, CAMERA, np.eye(4)).render(pose)
    behind = np.zeros(depth.shape, bool)
    behind[8:40, 8:56] = True
    assert (depth[behind] == 0).all()
    assert (rgb[behind] == 0).all()
    assert (ids[behind] == 0).all()
    _, depth, _, _ = MeshRenderer(surface.seen_from_both_sides(), CAMERA, np.eye(4)).render(pose)
    np.testing.assert_allclose(depth[20:28, 20:44], 1.5, atol=0.02)


@pytest.mark.parametrize(
    ("rotation", "shift", "seed"),
    [
        (np.eye(3), (0, 0, 0), 0),
        (Z_TO_Y, (300.0, -200.0, 25.0), 1),
        (np.array([[1, 0, 0], [0, 0.94, -0.342], [0, 0.342, 0.94]]), (1, 2, 3), 2),
    ],
    ids=["z up", "y up and far away", "tilted"],
)
def test_the_walk_keeps_out_of_furniture_and_upright(rotation: np.ndarray, shift: tuple, seed: int) -> None:
    truth = turned(furnished_room(noise_m=0.003), rotation, shift)
    centers = walked(truth, seed=seed)
    distance, _ = cKDTree(dense(truth)).query(centers)
    assert distance.min() > 0.295
    at_home = (centers - shift) @ np.linalg.inv(rotation).T
    (low, high), (x, y, z) = TABLE, at_home.T
    assert not ((x > low[0]) & (x < high[0]) & (y > low[1]) & (y < high[1])).any()
    assert np.abs(z - 1.5).max() < 0.1
    assert np.linalg.norm(np.diff(centers, axis=0), axis=1).max() * 15 < 0.55
    # All round the table.
    assert len(np.unique(np.round(np.arctan2(y, x)))) == 7


def test_the_walk_sees_everything_and_the_truth_says_so(sequence: MeshSequence) -> None:
    truth = sequence.truth()
    assert set(np.unique(truth.instances[truth.visible])) == set(range(1, 9))
    np.testing.assert_array_equal(truth.vertices, furnished_room(noise_m=0.003).vertices)
    # Nothing under the table, and most of the floor beside it.
    x, y, z = truth.vertices.T
    under = (truth.instances == 1) & (np.abs(x) < 0.55) & (np.abs(y) < 0.35)
    assert not truth.visible[under].any()
    on_wall = (truth.instances == 3) & (z > 0.8) & (z < 1.8)
    assert truth.visible[on_wall].mean() > 0.8


def same(one: Frame, other: Frame) -> bool:
    pairs = ((one.rgb, other.rgb), (one.depth, other.depth), (one.instance_ids, other.instance_ids))
    return all(np.array_equal(a, b) for a, b in pairs) and np.array_equal(one.pose, other.pose)


def test_frames_are_a_pure_function_of_the_arguments(mesh: Path, sequence: MeshSequence) -> None:
    again = pickle.loads(pickle.dumps(sequence))
    assert (again.name, len(again)) == (sequence.name, 60)
    assert same(again[7], sequence[7])
    planted = MeshSequence(mesh, 0, *FEW, misalignment=RgbdMisalignment(0.9))
    np.testing.assert_array_equal(planted[7].depth, sequence[7].depth)
    assert not np.array_equal(planted[7].rgb, sequence[7].rgb)
    assert planted.truth().rgbd_calibration is not None
    assert not np.allclose(MeshSequence(mesh, 5, *FEW)[7].pose, sequence[7].pose)


def test_faces_turned_round_or_at_random_show_the_same(tmp_path: Path, sequence: MeshSequence) -> None:
    truth = furnished_room(noise_m=0.003)
    at_random = np.random.default_rng(0).random(len(truth.triangles)) < 0.5
    for number, turned_round in enumerate((np.ones_like(at_random), at_random)):
        triangles = np.where(turned_round[:, None], truth.triangles[:, ::-1], truth.triangles)
        folder = tmp_path / str(number)
        folder.mkdir()
        write_truth(replace(truth, triangles=triangles), folder)
        other = MeshSequence(folder, 0, *FEW)
        frame = other[6]
        assert (frame.depth > 0).mean() > 0.5
        visible = other.truth().visible
        assert set(np.unique(truth.instances[visible])) == set(range(1, 9))


def test_up_can_be_said() -> None:
    truth = furnished_room()
    (transform,) = upright_from_mesh(truth, "0,0,2")
    np.testing.assert_allclose(transform, np.eye(4), atol=0.02)
    (transform,) = upright_from_mesh(turned(truth, Z_TO_Y), "-y")
    np.testing.assert_allclose(transform[2, :3], (0, -1, 0), atol=1e-9)
    for wrong in ("w", "0,0,0", "1,2"):
        with pytest.raises(BadInput, match="--up"):
            upright_from_mesh(truth, wrong)


def test_where_nobody_fits_there_is_no_walk() -> None:
    narrow = turned(furnished_room(), np.diag([1, 0.18, 1]))
    with pytest.raises(BadInput, match="no free floor"):
        walked(narrow, "z")


def test_a_mesh_that_is_no_place_is_refused(tmp_path: Path) -> None:
    truth = furnished_room()
    cases = {
        "has no faces": replace(truth, triangles=truth.triangles[:0]),
        "millimetres, add --mesh-scale 0.001": replace(truth, vertices=truth.vertices * 1000),
        "belong to nobody": replace(truth, instances=truth.instances * 0),
        "no finite numbers": replace(truth, vertices=np.where(truth.instances[:, None] == 6, np.nan, truth.vertices)),
    }
    for number, (words, wrong) in enumerate(cases.items()):
        folder = tmp_path / str(number)
        folder.mkdir()
        write_truth(wrong, folder)
        with pytest.raises(BadInput, match=words):
            MeshSequence(folder)
    scaled = MeshSequence(tmp_path / "1", 0, *FEW, scale=0.001)
    np.testing.assert_allclose(scaled.truth().vertices, truth.vertices, atol=1e-4)
