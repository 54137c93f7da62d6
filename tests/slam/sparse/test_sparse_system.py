"""Few pictures far apart, in any order: where they were taken, what is lost, and what little is no recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from data_tools import open_sequence
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from razer.geometry import inverse, is_rigid
from slam.pose_edge import EDGE_SHARE, PoseEdge
from slam.se3 import angle_deg, exp_se3, length_m
from slam.sparse.limits import has_failed
from slam.sparse.solved_poses import SolvedPoses
from slam.sparse.sparse_system import SparseSystem, picture_view
from slam.uncertainty.pose_uncertainty import final_uncertainty

SURE = np.eye(6) / 0.01**2 / EDGE_SHARE
STRIDE, N = 20, 10  # of 30 frames a second, 0.3 m and 15 degrees apart


@pytest.fixture(scope="module")
def shots():
    clip = SyntheticScene("room", 2, 480, 320, 240, sensor=SensorModel.kinect())
    return [clip[n * STRIDE] for n in range(N)]


def solved(shots):
    """A system that was shown shots in this order, as if they had been taken in it."""
    system = SparseSystem()
    for n, shot in enumerate(shots):
        system.locate(replace(shot, index=n, stamp=n / 2, world_from_camera=None))
    system.finish()
    return system


def assert_as_true(poses, truth, max_m=0.02, max_deg=1.0):
    first = min(poses)
    for n, pose in poses.items():
        off = inverse(inverse(truth[first]) @ truth[n]) @ inverse(poses[first]) @ pose
        assert length_m(off) < max_m
        assert angle_deg(off) < max_deg


@pytest.fixture(scope="module")
def in_order(shots):
    return solved(shots)


def test_pictures_in_any_order_are_located_where_they_were_taken(shots, in_order):
    order = np.random.default_rng(4).permutation(N).tolist()
    shuffled = solved([shots[n] for n in order]).trajectory()
    assert sorted(shuffled) == list(range(N))
    np.testing.assert_allclose(shuffled[0], np.eye(4), atol=1e-6)  # the world is the first one's
    assert_as_true(shuffled, [shots[n].pose for n in order])
    ordered = in_order.trajectory()
    assert_as_true(shuffled, [ordered[n] for n in order], 0.01, 0.3)


def test_poses_come_at_the_end_all_at_once(shots, in_order):
    assert in_order.locate(shots[0]) is None
    news = in_order.corrections()
    assert news.keys() == in_order.trajectory().keys()
    assert all(is_rigid(pose) for pose in news.values())
    assert in_order.corrections() == {}


def test_what_was_solved_is_handed_out_frame_by_frame(shots, in_order):
    report = in_order.report()
    assert report.graph is not None
    poses = SolvedPoses(in_order.trajectory(), in_order.quality, report.graph)
    for n, shot in enumerate(shots):
        np.testing.assert_array_equal(poses.locate(replace(shot, index=n)), poses.poses[n])
        told = poses.report()
        assert (told.graph is not None) == (n == 0)
        assert told.tracking.n_features >= 8
    assert poses.locate(replace(shots[0], index=N)) is None
    assert poses.corrections() == {}
    poses.finish()
    graph = poses.report().graph
    assert len(graph.frames) == N
    assert graph.n_loops == len(graph.edges) - (N - 1)
    assert graph.covariances.keys() == set(range(N))


def test_pictures_of_another_place_are_lost(shots):
    elsewhere = SyntheticScene("room", 9, 480, 320, 240, sensor=SensorModel.kinect())
    mixed = [shots[0], elsewhere[100], *shots[1:5], elsewhere[104], shots[5]]
    assert len(solved([elsewhere[100], elsewhere[104]]).trajectory()) == 2
    system = solved(mixed)
    poses = system.trajectory()
    assert sorted(poses) == [0, 2, 3, 4, 5, 7]
    assert_as_true(poses, [shot.pose for shot in mixed])
    assert system.report().graph.n_unanchored == 2
    assert sorted(system.graph.poses) == sorted(poses)
    assert all(edge.a in poses and edge.b in poses for edge in system.graph.edges)
    assert system.n_loops == len(system.graph.edges) - (len(poses) - 1)


def test_little_is_no_recording(shots):
    nothing = SparseSystem()
    nothing.finish()
    assert nothing.trajectory() == {}
    assert nothing.n_loops == 0
    blank = replace(shots[0], rgb=np.zeros_like(shots[0].rgb), depth=np.zeros_like(shots[0].depth))
    assert len(solved([shots[0]]).trajectory()) == 1
    assert len(solved([blank, blank]).trajectory()) == 1


@pytest.mark.parametrize(
    ("n_lost", "n_frames", "failed"), [(26, 100, True), (25, 100, False), (291, 301, False), (1, 1, False)]
)
def test_many_lost_frames_of_a_short_recording_are_a_failure(n_lost, n_frames, failed):
    assert has_failed(n_lost, n_frames) == failed


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.full) for seed in (2, 3, 4))])
def test_a_real_kitchen_in_any_order(seed, real_data):
    """Its exposure changes, and depth puts pictures two to five hundredths from where their features lie on each other:
    of two parts grown apart ever so much has another colour."""
    clip = open_sequence(real_data / "redkitchen")
    shots = [clip[int(n)] for n in np.random.default_rng(seed).permutation(range(0, 600, 30))]
    poses = solved(shots).trajectory()
    assert len(poses) == len(shots)
    assert_as_true(poses, [shot.pose for shot in shots], 0.15, 5.0)


@pytest.mark.parametrize("n_off", [1, 3])
def test_pictures_whose_edges_prove_false_are_lost_and_the_others_have_covariances(shots, n_off):
    """They are tied to the others by edges that contradict each other, and these to nobody."""
    system, numbers = SparseSystem(), range(4 + n_off)
    for number in numbers:
        system.keyframes.add(picture_view(replace(shots[0], index=number), system.config), np.eye(4), 0, 0.0)
    system._start_graph([PoseEdge(a, b, np.eye(4), SURE) for a, b in ((0, 1), (1, 2), (2, 3), (0, 3))])
    for number in numbers[4:]:
        ways = ((0, 3.0), (1, -3.0)) if number == 4 else ((number - 1, 0.0),)
        for before, x_m in ways:
            system.graph.add_edge(PoseEdge(before, number, exp_se3(np.array([0, 0, 0, x_m, 0, 0])), SURE))
    system._set_poses(system.graph.smooth())
    system._drop_outliers()
    assert sorted(system.trajectory()) == [0, 1, 2, 3]
    uncertainty = final_uncertainty(system.graph, 1.0)
    assert sorted(uncertainty.covariances) == sorted(uncertainty.local_sigmas_m) == [0, 1, 2, 3]


def test_of_a_picture_no_more_is_kept_than_is_matched(shots):
    kept = picture_view(shots[0], SparseSystem().config).wide
    assert kept._frame is None
    assert len(kept.features) > 100
