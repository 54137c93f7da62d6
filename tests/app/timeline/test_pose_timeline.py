"""Pose estimation on the timeline, read back from the recording of a run in which the camera went blind for a while."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
import rerun.blueprint as rrb
from scipy.spatial import cKDTree

from app.frames.frame_packet import AfterLastFrame, PosesFinal
from app.frames.locator import Locator
from app.render.viewpoint import behind
from app.run_folder.save_run import write_pose_covariances
from app.timeline import entities as paths
from app.timeline.config import TimelineConfig
from app.timeline.poses.trajectory_lines import TrajectoryLines, dashed
from app.timeline.recording.ellipsoids import position_ellipsoids
from app.timeline.recording.layout import RunView, run_layout
from app.timeline.rerun_timeline import Timeline
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from razer.frame import Intrinsics
from razer.geometry import inverse
from slam.backend.pose_graph import PoseEdge
from slam.frontend.keyframes import Keyframe
from slam.poses import GivenPoses
from slam.report import GraphReport, PoseReport, TrackingQuality
from slam.se3 import exp_se3
from slam.system import SlamSystem
from tests.support.timeline_rows import chunks_of

CAMERA = Intrinsics(64, 48, 50.0, 50.0, 31.5, 23.5)
N_FRAMES, BLIND = 36, range(20, 24)


class BlindSpell:
    """A simulated recording whose frames show nothing for a while."""

    def __init__(self):
        self._scene = SyntheticScene("room", 1, 100, 320, 240, sensor=SensorModel.kinect())
        self.intrinsics = self._scene.intrinsics

    def __getitem__(self, index):
        frame = self._scene[index]
        if index in BLIND:
            return replace(frame, rgb=np.zeros_like(frame.rgb), depth=np.zeros_like(frame.depth))
        return frame


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The estimation when it is done, its packets, and the recording."""
    path = tmp_path_factory.mktemp("poses") / "timeline.rrd"
    clip = BlindSpell()
    locator = Locator(clip, SlamSystem)
    timeline = Timeline(path, clip.intrinsics, TimelineConfig(path_every=1, ellipsoid_sigmas=2.0))
    packets = [locator(index) for index in range(N_FRAMES)]
    for packet in packets:
        track(timeline, packet)
    final = locator(AfterLastFrame.FINISH_POSES)
    assert isinstance(final, PosesFinal)
    timeline.finish_tracking(final.pose_update.report, final.pose_update.corrections)
    timeline.close()
    return SimpleNamespace(slam=locator.poses, packets=packets, final=final.pose_update, recording=chunks_of(path))


def track(timeline, packet):
    """Log a frame as the main loop does."""
    update = packet.pose_update
    timeline.track(packet.index, update.report, corrections=update.corrections, given=update.given)


def last(run, entity, component):
    return np.array([row for row in run.recording[entity] if row.get(component) is not None][-1][component])


def strips(run, entity):
    rows = [row["strips"] for row in run.recording[entity] if row.get("strips") is not None]
    return [np.array(strip) for strip in rows[-1]]


def test_every_keyframe_is_a_point_at_its_final_position(run):
    shown = last(run, paths.KEYFRAMES, "positions")
    assert len(shown) == len(run.slam.keyframes) > 3
    np.testing.assert_allclose(shown, run.slam.keyframes.poses()[:, :3, 3], atol=1e-6)


def test_every_edge_is_a_line_between_its_keyframes(run):
    positions = run.slam.keyframes.poses()[:, :3, 3]
    for entity, is_odometry in ((paths.ODOMETRY, True), (paths.CLOSURES, False)):
        edges = [(edge.a, edge.b) for edge in run.slam.graph.edges if edge.is_odometry is is_odometry]
        assert len(edges) > 1
        np.testing.assert_allclose(strips(run, entity), positions[np.array(edges)], atol=1e-6)


def test_the_estimated_path_ends_as_the_trajectory_broken_where_the_camera_was_blind(run):
    lines = strips(run, f"{paths.ESTIMATED}/whole")
    trajectory = run.slam.trajectory()
    found_again = min(index for index in trajectory if index >= BLIND.stop)
    assert [len(line) for line in lines] == [BLIND.start, N_FRAMES - found_again]
    expected = np.array([trajectory[index][:3, 3] for index in sorted(trajectory)])
    np.testing.assert_allclose(np.concatenate(lines), expected, atol=0.0021)
    assert strips(run, f"{paths.ESTIMATED}/newest") == []


def test_the_path_grows_from_frame_to_frame(run):
    """The whole as last drawn together with what is newest is one line to the camera of the frame."""
    drawn = {}
    for part in ("whole", "newest"):
        for row in run.recording[f"{paths.ESTIMATED}/{part}"]:
            if row.get("strips") is not None:
                drawn.setdefault(row["frame"], {})[part] = row["strips"]
    whole = []
    for index in range(1, BLIND.start):
        whole = drawn[index].get("whole", whole)
        newest = drawn[index]["newest"]
        ends = [strip[-1] for strip in (newest or whole)]
        position = run.packets[index].pose_update.report.world_from_camera[:3, 3]
        np.testing.assert_allclose(ends[-1], position, atol=1e-6)


def test_the_given_path_is_moved_rigidly_onto_the_first_estimated_pose_and_dashed(run):
    dashes = strips(run, f"{paths.GIVEN}/whole")
    given = [packet.pose_update.given for packet in run.packets]
    first = run.slam.trajectory()[0] @ inverse(given[0])
    line = np.array([(first @ pose)[:3, 3] for pose in given])
    assert len(dashes) > 3
    distance_m = cKDTree(densely(line)).query(np.concatenate(dashes))[0]
    assert distance_m.max() < 0.005
    drawn_m = sum(np.linalg.norm(np.diff(dash, axis=0), axis=1).sum() for dash in dashes)
    length_m = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    assert 0.4 < drawn_m / length_m < 0.6


def densely(line):
    return np.concatenate([np.linspace(a, b, 20) for a, b in pairwise(line)])


def test_dashes_and_gaps_are_as_long_as_asked_for():
    dashes = dashed([np.array([[0.0, 0, 0], [0.5, 0, 0], [1.0, 0, 0]])], dash_m=0.2)
    assert [[dash[0, 0], dash[-1, 0]] for dash in dashes] == [
        pytest.approx([0.0, 0.2]),
        pytest.approx([0.4, 0.6]),
        pytest.approx([0.8, 1.0]),
    ]
    assert dashes[1][1, 0] == 0.5  # the bend is kept
    assert dashed([]) == []


def test_loss_and_recovery_are_told_once_each_and_why(run):
    found_again = next(p.index for p in run.packets[BLIND.stop :] if p.pose_update.report.world_from_camera is not None)
    lost, found = [row for row in run.recording[paths.POSE_EVENTS] if "the camera is" in row["text"][0]]
    assert (lost["frame"], lost["level"]) == (BLIND.start, ["WARN"])
    assert lost["text"][0].startswith(f"the camera is lost from frame {BLIND.start} on: its view fits none")
    assert (found["frame"], found["level"]) == (found_again, ["INFO"])
    n_lost = found_again - BLIND.start
    assert found["text"][0].startswith(f"the camera is found again in frame {found_again} after {n_lost} lost frames")
    tracked = {row["frame"]: row["scalars"] for row in run.recording[paths.TRACKED] if "scalars" in row}
    lost_frames = range(BLIND.start, found_again)
    assert tracked == {index: [float(index not in lost_frames)] for index in range(N_FRAMES)}
    assert [r["frame"] for r in run.recording[paths.LOST_MARKS] if "scalars" in r] == list(lost_frames)


def test_the_places_where_the_camera_was_lost_and_found_are_marked(run):
    trajectory = run.slam.trajectory()
    found_again = min(index for index in trajectory if index >= BLIND.stop)
    for entity, frame, label in (
        (paths.LOST, BLIND.start - 1, f"lost after frame {BLIND.start - 1}"),
        (paths.FOUND, found_again, f"found in frame {found_again}"),
    ):
        row = [row for row in run.recording[entity] if row.get("positions")][-1]
        assert row["labels"] == [label]
        np.testing.assert_allclose(row["positions"], [trajectory[frame][:3, 3]], atol=0.01)


def test_how_well_a_frame_was_found_is_plotted_and_the_curves_break_where_it_was_not(run):
    for packet in run.packets:
        found = packet.pose_update.report.tracking
        if found is None:
            assert packet.index == 0 or packet.pose_update.report.world_from_camera is None
            continue
        for entity, values in (
            (paths.FEATURES_FOUND, [found.n_features]),
            (paths.DEPTH_FOUND, [found.score, found.agreement]),
            (paths.SIGMA, [100 * found.sigma_shift_m]),
        ):
            assert [r["scalars"] for r in run.recording[entity] if r.get("frame") == packet.index] == [values]
    cleared = {row["frame"] for row in run.recording[paths.SIGMA] if "is_recursive" in row}
    assert cleared == {p.index for p in run.packets if p.pose_update.report.tracking is None}
    sizes = [len(run.slam.keyframes), len(run.slam.graph.edges), run.slam.n_loops, 0]
    assert last(run, paths.GRAPH_SIZE, "scalars").tolist() == sizes


def test_ellipsoids_are_those_of_the_final_covariances(run):
    covariances = run.final.graph.covariances
    assert list(covariances) == [keyframe.view.index for keyframe in run.slam.keyframes.all]
    sigma_m = [np.sqrt(np.linalg.eigvalsh(c[3:, 3:])) for c in covariances.values()]
    np.testing.assert_allclose(last(run, paths.ELLIPSOIDS, "half_sizes"), 2 * np.array(sigma_m), rtol=1e-4)
    np.testing.assert_allclose(last(run, paths.ELLIPSOIDS, "centers"), run.slam.keyframes.poses()[:, :3, 3], atol=1e-6)


def test_the_newest_keyframes_covariance_comes_with_each_optimisation(run):
    graphs = [p.pose_update.graph for p in run.packets if p.pose_update.graph is not None]
    assert len(graphs) == len(run.slam.keyframes)
    assert all(list(graph.covariances) == [graph.frames[-1]] for graph in graphs)
    assert run.packets[1].pose_update.graph is None


def test_covariances_are_kept_symmetric_and_positive_definite(run, tmp_path):
    write_pose_covariances(tmp_path / "c.npz", run.final.graph)
    kept = np.load(tmp_path / "c.npz")
    n = len(run.slam.keyframes)
    assert kept["covariances"].shape == (n, 6, 6)
    assert (kept["covariances"] == kept["covariances"].swapaxes(1, 2)).all()
    assert (np.linalg.eigvalsh(kept["covariances"]) > 0).all()
    assert kept["frames"].tolist() == [keyframe.view.index for keyframe in run.slam.keyframes.all]
    assert kept["stamps"].tolist() == [keyframe.view.stamp for keyframe in run.slam.keyframes.all]
    np.testing.assert_allclose(kept["world_from_camera"], run.slam.keyframes.poses())
    known = run.final.graph.covariances
    assert all((kept["covariances"][row] == known[frame]).all() for row, frame in enumerate(kept["frames"].tolist()))
    # The first one is held fast; the others follow from it.
    spread = np.trace(kept["covariances"], axis1=1, axis2=2)
    assert (spread[1:] > 10 * spread[0]).all()


def test_a_keyframe_without_a_covariance_is_left_out_of_the_file(tmp_path):
    graph = replace(graph_at(np.zeros((3, 3))), covariances={20: np.eye(6)})
    write_pose_covariances(tmp_path / "c.npz", graph)
    kept = np.load(tmp_path / "c.npz")
    assert kept["frames"].tolist() == [20]
    assert kept["covariances"].shape == (1, 6, 6)
    write_pose_covariances(tmp_path / "none.npz", replace(graph, covariances={}))
    assert np.load(tmp_path / "none.npz")["covariances"].shape == (0, 6, 6)


def test_keyframes_that_nothing_ties_to_the_first_are_counted_and_not_placed():
    def keyframe(number, submap):
        view = SimpleNamespace(index=10 * number, stamp=number / 3)
        return Keyframe(number, submap, view, pose_at(number), 0.0)

    keyframes = [keyframe(0, 0), keyframe(1, 1), keyframe(2, 1), keyframe(3, 0)]
    edges = [PoseEdge(1, 2, np.eye(4), np.eye(6), is_odometry=True), PoseEdge(0, 3, np.eye(4), np.eye(6))]
    graph = GraphReport.of(keyframes, edges, 0, {2: np.eye(6), 3: 2 * np.eye(6)})
    assert graph.frames.tolist() == [0, 30]
    assert graph.n_unanchored == 2
    assert graph.edges.tolist() == [[0, 1]]  # rows, not numbers
    assert graph.is_odometry.tolist() == [False]
    assert list(graph.covariances) == [30]
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


def test_half_sizes_are_the_roots_of_the_eigenvalues_along_axes_turned_into_the_world():
    covariance = np.diag([9.0, 9, 9, 0.04, 0.01, 0.09])
    turned = exp_se3(np.array([0, 0, np.pi / 2, 5.0, 6.0, 7.0]))  # the camera's x axis is the world's y
    found = position_ellipsoids(turned[None], covariance[None], sigmas=1.0)
    np.testing.assert_allclose(found.centers, [[5, 6, 7]])
    np.testing.assert_allclose(found.half_sizes, [[0.1, 0.2, 0.3]])
    assert np.linalg.det(found.rotations[0]) == pytest.approx(1)
    spread = found.rotations[0] @ np.diag(found.half_sizes[0] ** 2) @ found.rotations[0].T
    np.testing.assert_allclose(spread, np.diag([0.01, 0.04, 0.09]), atol=1e-12)
    np.testing.assert_allclose(position_ellipsoids(turned[None], covariance[None], 3.0).half_sizes, [[0.3, 0.6, 0.9]])


def pose_at(x):
    return exp_se3(np.array([0, 0, 0, x, 0, 0]))


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


def names(part):
    children = getattr(part, "contents", ()) if not isinstance(part, rrb.View) else ()
    return [part.name, *(name for child in children for name in names(child))]


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


def test_a_run_has_four_tabs_and_plots_of_the_estimation_only_where_poses_are_estimated():
    view = behind(np.eye(4))
    layouts = [run_layout(RunView(view, view, estimated)).root_container for estimated in (False, True)]
    for layout in layouts:
        assert [tab.name for tab in layout.contents] == ["Overview", "Objects", "Poses", "Performance"]
        assert layout.active_tab == 0
    given, estimated = map(names, layouts)
    assert set(estimated) - set(given) == {"Position uncertainty, cm", "Lost and found, closures, corrections"}


def test_given_poses_are_not_logged(tmp_path):
    locator = Locator(BlindSpell(), GivenPoses)
    timeline = Timeline(tmp_path / "given.rrd", CAMERA, TimelineConfig())
    for index in (0, 1):
        track(timeline, locator(index))
    final = locator(AfterLastFrame.FINISH_POSES)
    timeline.finish_tracking(final.pose_update.report, final.pose_update.corrections)
    timeline.close()
    assert not [entity for entity in chunks_of(tmp_path / "given.rrd") if entity.startswith(("poses/e", "plots/t"))]
