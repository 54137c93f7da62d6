"""Pose graphs, loops and paths on the timeline, from reports made by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from app.run_folder.save_run import write_pose_covariances
from app.timeline import entities as paths
from app.timeline.config import TimelineConfig
from app.timeline.poses.trajectory_lines import TrajectoryLines
from app.timeline.rerun_timeline import Timeline
from razer.frame import Intrinsics
from slam.backend.pose_graph import PoseGraph
from slam.frontend.keyframes import Keyframe, Keyframes
from slam.pose_edge import PoseEdge
from slam.report import GraphReport, OpenStretch, PoseReport, PoseUncertainty, TrackingQuality
from slam.se3 import exp_se3
from tests.support.timeline_rows import chunks_of

CAMERA = Intrinsics(64, 48, 50.0, 50.0, 31.5, 23.5)


def pose_at(x):
    return exp_se3(np.array([0, 0, 0, x, 0, 0]))


def test_keyframes_that_nothing_ties_to_the_first_are_counted_and_not_placed():
    def keyframe(number, submap):
        view = SimpleNamespace(index=10 * number, stamp=number / 3)
        return Keyframe(number, submap, view, pose_at(number), 0.0)

    keyframes, poses = Keyframes(), PoseGraph()
    keyframes.all = [keyframe(0, 0), keyframe(1, 1), keyframe(2, 1), keyframe(3, 0)]
    poses.add_edge(PoseEdge(1, 2, np.eye(4), np.eye(6), is_odometry=True))
    poses.add_edge(PoseEdge(0, 3, np.eye(4), np.eye(6)))
    graph = GraphReport.of(keyframes, poses, 0, PoseUncertainty({2: np.eye(6), 3: 2 * np.eye(6)}, {0: 0.1, 2: 0.2}))
    assert graph.frames.tolist() == [0, 30]
    assert graph.n_unanchored == 2
    assert graph.edges.tolist() == [[0, 1]]  # rows, not numbers
    assert graph.is_odometry.tolist() == [False]
    assert list(graph.covariances) == [30]
    assert graph.local_sigmas_m == {0: 0.1}
    np.testing.assert_allclose(graph.world_from_camera[:, 0, 3], [0, 3])


def graph_at(positions):
    poses = np.tile(np.eye(4), (len(positions), 1, 1))
    poses[:, :3, 3] = positions
    return GraphReport(
        frames=10 * np.arange(len(positions)),
        stamps=np.arange(len(positions)) / 3,
        world_from_camera=poses,
        edges=np.array([(n, n + 1) for n in range(len(positions) - 1)]).reshape(-1, 2),
        is_odometry=np.ones(len(positions) - 1, bool),
        n_loops=0,
        n_unanchored=0,
        covariances={},
    )


def test_a_keyframe_without_a_covariance_is_left_out_of_the_file(tmp_path):
    graph = replace(graph_at(np.zeros((3, 3))), covariances={20: np.eye(6)})
    write_pose_covariances(tmp_path / "c.npz", graph)
    kept = np.load(tmp_path / "c.npz")
    assert kept["frames"].tolist() == [20]
    assert kept["covariances"].shape == (1, 6, 6)
    write_pose_covariances(tmp_path / "none.npz", replace(graph, covariances={}))
    none = np.load(tmp_path / "none.npz")
    assert none["covariances"].shape == (0, 6, 6)
    assert (none["open_frames"].shape, none["open_axes"].shape) == ((0, 2), (0, 3))


def test_stretches_in_which_a_direction_was_open_are_kept(tmp_path):
    stretches = (OpenStretch(20, 40, np.array([0, 0, 1.0])), OpenStretch(70, 75, np.array([0.6, 0.8, 0])))
    write_pose_covariances(tmp_path / "c.npz", replace(graph_at(np.zeros((3, 3))), open=stretches))
    kept = np.load(tmp_path / "c.npz")
    assert kept["open_frames"].tolist() == [[20, 40], [70, 75]]
    np.testing.assert_array_equal(kept["open_axes"], [[0, 0, 1], [0.6, 0.8, 0]])


def test_an_optimisation_that_moves_keyframes_is_shown_before_and_after(tmp_path):
    before = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    after = before + np.array([[0, 0, 0], [0, 0.03, 0], [0, 0.06, 0]])
    grown = np.concatenate([after + 0.001, [[3, 0, 0]]])
    timeline = Timeline(tmp_path / "moved.rrd", CAMERA, TimelineConfig(shown_move_m=0.05))
    for index, positions in enumerate((before, after, grown)):
        report = PoseReport(np.eye(4), TrackingQuality(50, 0.9, 0.8, 1e-3, 2e-3), graph_at(positions))
        timeline.track(index, report, corrections={})
    timeline.close()
    recording = chunks_of(tmp_path / "moved.rrd")
    (row,) = [row for row in recording[paths.CORRECTION] if row.get("strips") is not None]
    assert row["frame"] == 1
    np.testing.assert_allclose(row["strips"], np.stack([before, after], axis=1), atol=1e-6)
    assert [row["frame"] for row in recording[paths.CORRECTION] if "is_recursive" in row] == [0, 2]  # cleared
    assert [(row["frame"], row["text"][0]) for row in recording[paths.POSE_EVENTS]] == [
        (1, "keyframes moved by up to 6.0 cm")
    ]


def test_a_path_goes_on_from_where_the_whole_ended_and_takes_in_late_corrections():
    path = TrajectoryLines()
    for index, pose in ((0, pose_at(0)), (3, pose_at(1)), (6, None), (9, pose_at(3))):
        path.add(index, pose)
    assert [line[:, 0].tolist() for line in path.whole(np.eye(4))] == [[0, 1]]  # one frame alone is no line
    path.add(12, pose_at(4))
    assert [line[:, 0].tolist() for line in path.newest(np.eye(4))] == [[3, 4]]
    path.correct({6: pose_at(2), 12: pose_at(5)})
    assert [line[:, 0].tolist() for line in path.whole(pose_at(10))] == [[10, 11, 12, 13, 15]]
    assert path.newest(np.eye(4)) == []


def test_the_path_is_logged_every_so_often(tmp_path):
    timeline = Timeline(tmp_path / "path.rrd", CAMERA, TimelineConfig(path_every=3))
    for index in range(8):
        timeline.track(index, PoseReport(pose_at(index), None, None), corrections={})
    timeline.close()
    rows = chunks_of(tmp_path / "path.rrd")[f"{paths.ESTIMATED}/newest"]
    drawn = {row["frame"]: [x for strip in row["strips"] for x, _, _ in strip] for row in rows if "strips" in row}
    assert drawn == {0: [], 3: [0, 1, 2, 3], 6: [0, 1, 2, 3, 4, 5, 6]}


def test_a_loop_is_told_once_and_shines_until_the_next_optimisation(tmp_path):
    positions = np.zeros((3, 3))
    closed = replace(
        graph_at(positions), edges=np.array([[0, 1], [1, 2], [0, 2]]), is_odometry=np.array([1, 1, 0], bool)
    )
    timeline = Timeline(tmp_path / "loop.rrd", CAMERA, TimelineConfig())
    for index, graph in enumerate((graph_at(positions), closed, closed)):
        report = PoseReport(np.eye(4), TrackingQuality(50, 0.9, 0.8, 1e-3, 2e-3), graph)
        timeline.track(index, report, corrections={})
    timeline.close()
    recording = chunks_of(tmp_path / "loop.rrd")
    assert [(row["frame"], row["text"][0]) for row in recording[paths.POSE_EVENTS]] == [
        (1, "loop closed: frame 20 shows what frame 0 did")
    ]
    assert [(r["frame"], r["scalars"]) for r in recording[paths.CLOSURE_MARKS] if "scalars" in r] == [(1, [0.2])]
    shining = [len(row["strips"]) for row in recording[paths.NEWEST_CLOSURES] if row.get("strips") is not None]
    assert shining == [0, 1, 0]
