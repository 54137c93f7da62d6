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
from app.timeline.poses.trajectory_lines import dashed
from app.timeline.recording.ellipsoids import position_ellipsoids
from app.timeline.recording.layout import SIGMA_TITLE, RunView, run_layout
from app.timeline.rerun_timeline import Timeline
from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from razer.frame import Intrinsics
from razer.geometry import inverse
from slam.poses import GivenPoses
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
        dot, name = ([row for row in run.recording[e] if row.get("positions")][-1] for e in (entity, f"{entity}/names"))
        assert name["labels"] == [label]
        for row in (dot, name):
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


def names(part):
    children = getattr(part, "contents", ()) if not isinstance(part, rrb.View) else ()
    return [part.name, *(name for child in children for name in names(child))]


def test_a_run_has_four_tabs_and_plots_of_the_estimation_only_where_poses_are_estimated():
    view = behind(np.eye(4))
    layouts = [run_layout(RunView(view, view, view, estimated)).root_container for estimated in (False, True)]
    for layout in layouts:
        assert [tab.name for tab in layout.contents] == ["Overview", "Objects", "Poses", "Performance"]
        assert layout.active_tab == 0
    given, estimated = map(names, layouts)
    paths_title = "Path from above: given grey, estimated orange, corrections red"
    assert set(estimated) - set(given) == {SIGMA_TITLE, paths_title, "Lost and found, closures, corrections"}


def test_given_poses_are_not_logged(tmp_path):
    locator = Locator(BlindSpell(), GivenPoses)
    timeline = Timeline(tmp_path / "given.rrd", CAMERA, TimelineConfig())
    for index in (0, 1):
        track(timeline, locator(index))
    final = locator(AfterLastFrame.FINISH_POSES)
    timeline.finish_tracking(final.pose_update.report, final.pose_update.corrections)
    timeline.close()
    assert not [entity for entity in chunks_of(tmp_path / "given.rrd") if entity.startswith(("poses/e", "plots/t"))]


def test_the_given_path_hangs_on_another_frame_when_a_correction_takes_the_first_pose_away(run, tmp_path):
    timeline = Timeline(tmp_path / "timeline.rrd", CAMERA, TimelineConfig(path_every=1))
    for packet in run.packets[:3]:
        track(timeline, packet)
    timeline.finish_tracking(run.packets[2].pose_update.report, {0: None})
    timeline.finish_tracking(run.packets[2].pose_update.report, {1: None, 2: None})
    timeline.close()
    rows = [row for row in chunks_of(tmp_path / "timeline.rrd")[f"{paths.GIVEN}/whole"] if row.get("strips")]
    given = [packet.pose_update.given for packet in run.packets[:2]]
    estimated = run.packets[1].pose_update.report.world_from_camera
    hung = estimated @ inverse(given[1]) @ given[0]
    np.testing.assert_allclose(rows[-1]["strips"][0][0], hung[:3, 3], atol=1e-5)
