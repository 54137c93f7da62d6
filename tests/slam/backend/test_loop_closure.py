"""Which pairs of keyframes may be the same place, and which of them are worth measuring."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from razer.geometry import inverse
from slam.backend.loop_closure import MIN_GAIN, LoopClosure
from slam.backend.place_recognition import PlaceRecognition
from slam.backend.pose_graph import PoseGraph
from slam.backend.resistance_network import NEAREST
from slam.backend.verified_registration import VerifiedRegistration
from slam.backend.view_overlap import overlap_of, reading_points
from slam.config import LoopClosureSettings, SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.keyframes import Keyframes
from slam.pose_edge import EDGE_SHARE, PoseEdge
from slam.se3 import exp_se3, length_m

SIGMA = 0.01
INFORMATION = np.eye(6) / SIGMA**2 / EDGE_SHARE


class Turning:
    """Keyframes of a camera that turns to and fro on the spot, so that each sees much of all others; what is measured
    between two is exact, and counted."""

    def __init__(self, view, n):
        self.keyframes, self.graph = Keyframes(), PoseGraph()
        registration = VerifiedRegistration(self.keyframes, SlamConfig())
        self.loops = LoopClosure(self.keyframes, self.graph, PlaceRecognition(), registration, SlamConfig())
        registration.register = self.register
        self.measured: list[tuple[int, int]] = []
        for number in range(n):
            pose = exp_se3(np.array([0, 0.1 * np.sin(number), 0, 0, 0, 0]))
            self.keyframes.add(replace(view, index=number), pose, 0, 0.0)
            self.graph.add_keyframe(number, pose)
            if number:
                self.graph.add_edge(self.edge(number - 1, number, is_odometry=True))

    def edge(self, a, b, is_odometry=False):
        a_from_b = inverse(self.keyframes[a].world_from_camera) @ self.keyframes[b].world_from_camera
        return PoseEdge(a, b, a_from_b, INFORMATION, is_odometry)

    def register(self, keyframe, view, guesses, calibration):
        self.measured.append((keyframe.number, view.index))

    def measure_all(self):
        self.loops.queue_neighbors()
        while len(self.loops):
            n_measured = len(self.measured)
            self.loops.measure_next(ColorCalibration.nominal())
            if len(self.measured) > n_measured:
                self.graph.add_edge(self.edge(*self.measured[-1]))
        return self.measured


def back_after_drift(views, room, drift_m):
    """What is measured of a camera that comes back by a long way, so far beside where it is thought to be, to what does
    not stand out by its looks; and the true motion."""
    config = SlamConfig(loop_closure=LoopClosureSettings(min_similarity_sigmas=1e9))
    keyframes, graph, places = Keyframes(), PoseGraph(), PlaceRecognition()
    loops = LoopClosure(keyframes, graph, places, VerifiedRegistration(keyframes, config), config)
    truth = inverse(room[10].pose) @ room[12].pose
    away = [exp_se3(np.array([0, np.pi, 0, 10, 0, 0]))] * (NEAREST + 2)
    for number, pose in enumerate([np.eye(4), *away, exp_se3(np.array([0, 0, 0, drift_m, 0, 0])) @ truth]):
        is_back = number > len(away)
        keyframe = keyframes.add(views[12 if is_back else 10], pose, 0, float(number))
        graph.add_keyframe(number, pose)
        if number:
            a_from_b = inverse(keyframes[number - 1].world_from_camera) @ pose
            graph.add_edge(PoseEdge(number - 1, number, a_from_b, INFORMATION, is_odometry=True))
        loops.add(keyframe) if is_back else places.add(keyframe.view)
    found = [loops.measure_next(ColorCalibration.nominal()) for _ in range(len(loops))]
    return [edge for edge in found if edge is not None], truth


def test_a_camera_that_comes_back_beside_where_it_is_thought_to_be_is_recognised(views, room):
    """At those poses both views share nothing, and others look as much alike."""
    edges, truth = back_after_drift(views, room, drift_m=2.0)
    assert [(edge.a, edge.b) for edge in edges] == [(0, NEAREST + 3)]
    assert length_m(inverse(truth) @ edges[0].a_from_b) < 0.01


def test_pairs_that_are_measured_grow_with_the_keyframes_and_not_with_their_square(views):
    counts = {n: len(Turning(views[10], n).measure_all()) for n in (30, 60)}
    assert counts[60] < 60 * 59 / 2 / 5
    assert counts[60] < 2.5 * counts[30]


def test_no_pair_is_left_out_that_an_edge_would_make_surer(views):
    turning = Turning(views[10], 30)
    turning.measure_all()
    network, points = turning.graph.network, reading_points(views[10], 4.0)
    for number in range(30):
        variances = network.variances_from(number)
        for left in [n for n in range(number) if not network.joined(n, number)]:
            share = overlap_of(points, views[10], turning.edge(left, number).a_from_b)
            assert share < 0.3 or share * variances[left] < MIN_GAIN * network.usual_variance


def test_pairs_that_add_most_are_measured_first(views):
    a, b = Turning(views[10], 30).measure_all()[0]
    assert b - a >= 20


def test_an_edge_that_the_poses_contradict_makes_no_other_needless(views):
    turning = Turning(views[10], 30)
    wrong = exp_se3(np.array([0, 0, 0, 1.0, 0, 0]))
    turning.graph.add_edge(replace(turning.edge(0, 29), a_from_b=wrong))
    joined = turning.graph.network.variances_from(0)[29]
    turning.graph.doubt_edges()
    assert turning.graph.network.variances_from(0)[29] > 20 * joined


def test_the_keyframe_before_is_a_neighbour_as_any_other_where_nothing_joins_it(views):
    """Tracking may have gone on from an older one, and pictures in no order follow each other by chance."""
    turning = Turning(views[10], 3)
    turning.graph.replace([edge for edge in turning.graph.edges if edge.b != 2])
    near = dict(turning.loops._uncertain(turning.keyframes[2]))
    assert sorted(near) == [0, 1]
    assert dict(turning.loops._uncertain(turning.keyframes[1])) == {}


def test_keyframes_that_every_edge_contradicts_by_far_are_no_singular_network(views):
    turning = Turning(views[10], 4)
    sure = replace(turning.edge(0, 3), information=1e9 * np.eye(6))
    for a, b, x_m in ((0, 3, 1e4), (1, 3, -1e4)):
        wrong = exp_se3(np.array([0, 0, 0, x_m, 0, 0]))
        turning.graph.add_edge(replace(sure, a=a, b=b, a_from_b=wrong))
    turning.graph.replace([edge for edge in turning.graph.edges if (edge.a, edge.b) != (2, 3)])
    turning.graph.doubt_edges()
    variances = turning.graph.network.variances_from(0)
    assert variances[3] > 1e3 * variances[2]
