"""Submaps that are merged, moved and parted again, by hand-made views of a corridor."""

from __future__ import annotations

import numpy as np
import pytest

from razer.frame import Frame, Intrinsics
from slam.backend.pose_graph import PoseEdge, PoseGraph
from slam.backend.submaps.merge_hypotheses import MergeHypotheses, MergeHypothesis
from slam.backend.submaps.placement_check import PlacementCheck
from slam.backend.submaps.submap_merging import Outcome, SubmapMerging
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import FeatureExtractor
from slam.frontend.keyframes import STILL, Keyframes, View

CAMERA = Intrinsics(160, 120, 130.0, 130.0, 79.5, 59.5)
CONFIG = SlamConfig()
CERTAIN = 1e9 * np.eye(6)
WALL, BOARD = (180, 170, 160), (20, 60, 40)


def at(z_m, x_m=0.0):
    result = np.eye(4)
    result[[0, 2], 3] = x_m, z_m
    return result


def view(number, end_m, board=False):
    """A square corridor that ends after some metres, with a board on its right wall."""
    rows, columns = np.mgrid[0:120, 0:160]
    slant = np.maximum(np.abs((columns - 79.5) / 130.0), np.abs((rows - 59.5) / 130.0))
    depth = np.minimum(1.0 / np.maximum(slant, 1e-9), end_m).astype(np.float32)
    rgb = np.full((120, 160, 3), WALL, np.uint8)
    if board:
        rgb[30:90, 100:160] = BOARD
    frame = Frame(number, float(number), rgb, depth, CAMERA)
    features = FeatureExtractor(CONFIG).extract(frame, ColorCalibration.nominal())
    return View.of(frame, features, STILL, CONFIG)


class World:
    """Keyframes that are all one metre apart on the way to the end of a corridor, eight metres long: those of chain 0,
    and those of chain 1, which begin elsewhere."""

    def __init__(self, ends_m, submap=1, board=False):
        self.keyframes, self.graph = Keyframes(), PoseGraph()
        for number, end_m in enumerate([8.0, 7.0, 6.0, *ends_m]):
            chain = int(number > 2)
            pose = at(float(number) if not chain else 20.0 + number)
            self.keyframes.add(view(number, end_m, board and chain), pose, submap * chain, 0.0, chain)
            self.graph.add_keyframe(number, pose, unanchored=number == 3)
            if number not in (0, 3):
                self.graph.add_edge(PoseEdge(number - 1, number, at(1.0), CERTAIN, is_odometry=True))
        self.graph.optimise()
        hypotheses = MergeHypotheses(self.keyframes, CONFIG.submaps)
        placement = PlacementCheck(self.keyframes, self.graph, CONFIG)
        self.merging = SubmapMerging(self.keyframes, self.graph, hypotheses, placement)

    def say(self, a, b, z_m):
        """Three views say that keyframe b is z_m in front of keyframe a: what comes of each."""
        edge = PoseEdge(a, b, at(z_m), CERTAIN)
        return [self.merging.add(edge, frame, 1.0) for frame in (100, 101, 102)]

    @property
    def places_m(self):
        return [round(float(keyframe.world_from_camera[2, 3]), 2) for keyframe in self.keyframes.all]

    @property
    def submaps(self):
        return self.keyframes.submaps().tolist()


def test_a_submap_that_fits_is_merged_and_tied():
    world = World([7.5, 6.5])
    assert world.say(0, 3, 0.5) == [Outcome.WAITS, Outcome.WAITS, Outcome.MOVED]
    assert world.submaps == [0] * 5
    assert world.places_m == [0, 1, 2, 0.5, 1.5]
    world.graph.optimise()
    np.testing.assert_allclose(world.graph.poses[4], at(1.5), atol=1e-3)


def test_a_submap_that_stands_where_others_saw_through_is_not_merged():
    world = World([5.0, 4.0])
    assert world.say(0, 3, 0.5) == [Outcome.WAITS, Outcome.WAITS, Outcome.REFUTED]
    assert world.submaps == [0, 0, 0, 1, 1]
    assert world.places_m == [0, 1, 2, 23, 24]


@pytest.mark.parametrize(("ends_m", "is_merged"), [([7.5, 6.5], False), ([7.5, 6.5, 5.5], True)])
def test_the_colours_of_few_keyframes_must_fit_better(ends_m, is_merged):
    """As many differ as a hand-held camera may change, of which nothing is known yet: of two keyframes too many."""
    assert (World(ends_m, board=True).say(0, 3, 0.5)[-1] is Outcome.MOVED) is is_merged


def test_space_that_drift_contradicts_a_little_keeps_no_few_keyframes_apart():
    """5 % of what two keyframes read stands where others looked through, just less than is allowed."""
    assert World([7.5, 5.8]).say(0, 3, 0.5)[-1] is Outcome.MOVED


@pytest.mark.parametrize("aside_m", [0.0, 15.0])
def test_what_drift_along_the_way_explains_keeps_no_submap_apart(aside_m):
    """A submap whose last views see the end of the corridor a metre too near, after a way aside or straight on."""
    world = World([7.5, 6.5, 4.5, 3.5, 2.5])
    world.keyframes[4].world_from_camera = at(24.0, x_m=aside_m)
    assert (world.say(0, 3, 0.5)[-1] is Outcome.MOVED) is (aside_m > 0)


def test_where_views_were_refused_their_colours_must_fit_better():
    """What is allowed of their colours at first is too much then."""
    world = World([7.5, 6.5, 5.5], board=True)
    world.merging.hypotheses.refuse([MergeHypothesis(99, PoseEdge(0, 3, at(0.5), CERTAIN), 1.0)])
    assert world.say(0, 3, 0.5)[-1] is Outcome.WAITS  # twice as many are needed
    edge = PoseEdge(0, 3, at(0.5), CERTAIN)
    assert [world.merging.add(edge, frame, 1.0) for frame in (103, 104, 105)][-1] is Outcome.REFUTED
    assert World([7.5, 6.5, 5.5], board=True).say(0, 3, 0.5)[-1] is Outcome.MOVED


def test_a_place_of_the_same_shape_and_other_colours_is_another_place():
    world = World([7.5, 6.5], board=True)
    assert world.say(0, 3, 0.5)[-1] is Outcome.REFUTED
    assert world.submaps == [0, 0, 0, 1, 1]


@pytest.mark.parametrize("contradicts", [True, False])
def test_a_chain_is_parted_where_its_newest_views_contradict_the_others(contradicts):
    world = World([7.5, 6.5, *([3.0, 2.0] if contradicts else [5.5, 4.5])])
    shift = at(0.5 - 23.0)
    for number in range(3, 7):  # as if it had been merged by its first view
        keyframe = world.keyframes[number]
        keyframe.submap, keyframe.world_from_camera = 0, shift @ keyframe.world_from_camera
    world.graph.shift({k.number: k.world_from_camera for k in world.keyframes.all})
    world.graph.add_edge(PoseEdge(0, 3, at(0.5), CERTAIN))
    assert world.merging.review(1, 7) is contradicts
    assert world.submaps == [0, 0, 0, *([7] * 4 if contradicts else [0] * 4)]
    ties = {(edge.a, edge.b) for edge in world.graph.edges}
    assert ((0, 3) in ties) is not contradicts
    assert {(0, 1), (3, 4), (5, 6)} <= ties


def test_a_chain_is_reviewed_each_time_that_it_has_grown_by_four():
    world = World([7.5, 6.5, 3.0])
    for number in range(3, 6):
        keyframe = world.keyframes[number]
        keyframe.submap, keyframe.world_from_camera = 0, at(0.5 - 23.0) @ keyframe.world_from_camera
    world.graph.add_edge(PoseEdge(0, 3, at(0.5), CERTAIN))
    assert not world.merging.review(1, 7)
    world.keyframes.add(view(6, 2.0), at(3.5), 0, 0.0, 1)
    world.graph.add_keyframe(6, at(3.5))
    world.graph.add_edge(PoseEdge(5, 6, at(1.0), CERTAIN, is_odometry=True))
    assert world.merging.review(1, 7)


def test_a_chain_that_is_where_views_contradict_it_is_moved_to_where_others_say():
    world = World([7.5, 6.5], submap=0)
    for number in (3, 4):  # 1.5 m too far on: the end of the corridor would be beyond its end
        world.keyframes[number].world_from_camera = at(number - 3 + 2.0)
    world.graph.shift({k.number: k.world_from_camera for k in world.keyframes.all})
    world.graph.add_edge(PoseEdge(2, 3, at(0.0), CERTAIN))
    assert world.say(0, 3, 0.5)[-1] is Outcome.MOVED
    assert world.places_m == [0, 1, 2, 0.5, 1.5]
    assert (2, 3) not in {(edge.a, edge.b) for edge in world.graph.edges}


def test_a_chain_that_nothing_contradicts_stays_where_it_is():
    world = World([7.5, 6.5], submap=0)
    for number in (3, 4):
        world.keyframes[number].world_from_camera = at(number - 3 + 0.5)
    world.graph.shift({k.number: k.world_from_camera for k in world.keyframes.all})
    assert world.say(0, 3, 1.5)[-1] is Outcome.REFUTED
    assert world.places_m == [0, 1, 2, 0.5, 1.5]


def test_what_merged_a_chain_that_was_parted_must_come_up_anew():
    world = World([7.5, 6.5, 3.0, 2.0])
    merging, edge = world.merging, PoseEdge(0, 3, at(0.5), CERTAIN)
    for number in (5, 6):  # what contradicts is seen later
        world.keyframes[number].submap = 2
    assert world.say(0, 3, 0.5)[-1] is Outcome.MOVED
    for number in (5, 6):
        keyframe = world.keyframes[number]
        keyframe.submap, keyframe.world_from_camera = 0, at(0.5 - 23.0) @ keyframe.world_from_camera
    assert merging.review(1, 7)
    assert merging.add(edge, 103, 1.0) is Outcome.WAITS
    assert merging.add(edge, 104, 1.0) is Outcome.WAITS
    assert merging.add(edge, 105, 1.0) is Outcome.REFUTED


class Loop(World):
    """One chain that goes to the end of a corridor, far away, and then comes back into it, or into one whose end is
    nearer, a metre and more beside where it is thought to be."""

    def __init__(self, ends_m):
        super().__init__([8.0, *ends_m], submap=0)
        for keyframe in self.keyframes.all:
            keyframe.chain = 0
        self.graph.add_edge(PoseEdge(2, 3, at(21.0), CERTAIN, is_odometry=True))

    def come_back(self):
        """Three views, each of another keyframe, say that it is in the corridor once more."""
        edges = [PoseEdge(0, 4 + n, at(0.5 + n), CERTAIN) for n in range(3)]
        return [self.merging.add(edge, edge.b, 1.0) for edge in edges]


def test_a_loop_within_a_chain_is_closed_by_views_that_agree_without_moving_anything_at_once():
    world = Loop([7.5, 6.5, 5.5])
    before = world.places_m
    assert world.come_back() == [Outcome.WAITS, Outcome.WAITS, Outcome.MOVED]
    assert world.places_m == before  # the graph moves what is between
    assert {(0, 4), (0, 5), (0, 6)} <= {(edge.a, edge.b) for edge in world.graph.edges}


def test_a_loop_within_a_chain_stays_open_where_space_contradicts():
    world = Loop([5.5, 4.5, 3.5])
    assert world.come_back() == [Outcome.WAITS, Outcome.WAITS, Outcome.REFUTED]
    assert all(edge.is_odometry for edge in world.graph.edges)


def test_one_view_closes_no_loop_within_a_chain_however_many_keyframes_it_fits():
    world = Loop([7.5, 6.5, 5.5])
    edges = [PoseEdge(n, 4, at(0.5 - n), CERTAIN) for n in range(3)]
    assert [world.merging.add(edge, 4, 1.0) for edge in edges] == [Outcome.WAITS] * 3
