"""Pictures that lie in the wrong one of two look-alike places move, and those that lie right stay."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

from data_tools.synthetic.camera.sensor_model import SensorModel
from data_tools.synthetic.synthetic_scene import SyntheticScene
from slam.backend.pose_graph import PoseEdge
from slam.backend.view_checks.color_check import ColorDifference
from slam.backend.view_checks.usual_colors import UsualColors
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.features import FeatureExtractor
from slam.frontend.keyframes import STILL, Keyframes, View
from slam.se3 import exp_se3
from slam.sparse.camera_motion import CameraSpeed
from slam.sparse.known_pairs import KnownPairs, as_it_is
from slam.sparse.measured_pair import MeasuredPair, by_picture
from slam.sparse.placement.parts import Parts
from slam.sparse.placement.placed_pictures import PlacedPictures
from slam.sparse.placement.reassignment import PlacementFit, Reassignment

USUAL = UsualColors([0.5], [0.05])
TWIN_M = 5.0  # from one place to the one that looks like it
FITS = PlacementFit(0.0, 1.0)


def at(x_m: float):
    pose = np.eye(4)
    pose[0, 3] = x_m
    return pose


def pair(a, b, x_m, n_features=40):
    """b lies so far along x from a."""
    return MeasuredPair(PoseEdge(a, b, at(x_m), 1e6 * np.eye(6)), n_features, 0.5)


def told(pairs, here=FITS, there=FITS):
    """Of picture 5 it is told how it fits here and there; all others fit where they lie."""

    class Told(Reassignment):
        def _fit(self, number, pose, poses):
            if number == 5:
                return here if pose[0, 3] < TWIN_M / 2 else there
            return FITS if np.allclose(pose, poses[number]) else PlacementFit(0.2, None)

    return Told(None, supported(pairs), SlamConfig())


def supported(pairs, register=as_it_is):
    """Pairs that nothing speaks against, whatever triangles they make."""
    known = KnownPairs([], [], SlamConfig(), register=register)
    known.usual_colors, known.by_number, known.supported = USUAL, by_picture(pairs), by_picture(pairs)
    return known


def parts_of(pairs, n):
    keyframes, config = [None] * n, SlamConfig()
    return Parts(keyframes, KnownPairs(keyframes, pairs, config), config)


def moved(pairs, poses, here=FITS, there=FITS):
    return told(pairs, here, there).moved(poses)


POSES = {0: at(0.0), 1: at(0.1), 2: at(0.2), 10: at(TWIN_M), 11: at(TWIN_M + 0.1), 12: at(TWIN_M + 0.2)}
PLACES = [pair(a, b, POSES[b][0, 3] - POSES[a][0, 3]) for a in POSES for b in POSES if a < b < a + 3]
TWO_PLACES = [pair(a, b, 0.1 * (b - a)) for a, b in [(0, 1), (0, 2), (1, 2), (3, 4), (3, 5), (4, 5)]]


def ties(n_here, n_there):
    """Picture 5 lies at x = 0.3 by some of those here, and at the same place over there by some of those there."""
    return [*PLACES, *(pair(n, 5, 0.3 - 0.1 * n) for n in range(n_here))] + [
        pair(5, 10 + n, 0.1 * n - 0.3) for n in range(n_there)
    ]


@pytest.mark.parametrize(("n_here", "n_there", "moves"), [(1, 3, True), (1, 2, True), (2, 3, False), (3, 1, False)])
def test_where_colours_say_nothing_twice_the_ties_move_a_picture(n_here, n_there, moves):
    found = moved(ties(n_here, n_there), {**POSES, 5: at(0.3)})
    assert list(found) == ([5] if moves else [])
    if moves:
        np.testing.assert_allclose(found[5], at(TWIN_M + 0.3), atol=1e-12)


@pytest.mark.parametrize(
    ("here", "there", "moves"), [(3.0, 1.0, True), (1.0, 3.0, False), (1.1, 1.0, False), (1.0, 0.1, False)]
)
def test_colours_say_more_than_ties_where_more_than_usual_differ(here, there, moves):
    found = moved(ties(3, 2), {**POSES, 5: at(0.3)}, PlacementFit(0.0, here), PlacementFit(0.0, there))
    assert list(found) == ([5] if moves else [])


def test_ties_ever_so_many_move_no_picture_to_where_colours_differ():
    poses = {**POSES, 5: at(0.3)}
    assert not moved(ties(1, 3), poses, FITS, PlacementFit(0.0, 2.5))
    assert moved(ties(1, 3), poses, FITS, PlacementFit(0.0, 2.0))  # not clearly more


def test_space_says_more_than_colours_and_ties():
    poses, full, other = {**POSES, 5: at(0.3)}, PlacementFit(0.2, 1.0), PlacementFit(0.0, 3.0)
    assert list(moved(ties(3, 2), poses, full, other)) == [5]
    assert not moved(ties(1, 3), poses, other, full)


@pytest.mark.parametrize(("contradiction", "moves"), [(0.07, False), (0.2, True)])
def test_colours_hold_a_picture_against_a_little_contradiction(contradiction, moves):
    """As of a neighbour that lies wrong itself, or of a thin wall."""
    here, there = PlacementFit(contradiction, 0.1), PlacementFit(0.0, 2.0)
    assert list(moved(ties(3, 4), {**POSES, 5: at(0.3)}, here, there)) == ([5] if moves else [])


def test_what_no_tie_holds_goes_where_two_ties_or_a_strong_one_say():
    poses = {**POSES, 5: at(0.3)}
    assert list(moved(ties(0, 2), poses)) == [5]
    weak = [*PLACES, pair(5, 10, -0.3, n_features=11)]
    assert not moved(weak, poses)


def test_rough_ties_move_a_picture_if_their_registrations_say_so_too():
    poses = {**POSES, 5: at(0.3)}
    rough = [
        replace(one, is_registered=False) if one.ends in [(5, 10), (5, 11), (5, 12)] else one for one in ties(1, 3)
    ]
    exact = {
        one.ends: replace(one, edge=PoseEdge(*one.ends, at(one.edge.a_from_b[0, 3] - 0.02), np.eye(6))) for one in rough
    }
    assert list(told(rough).moved(poses)) == [5]

    def moved_by(register):
        reassignment = told(rough)
        return replace(reassignment, pairs=supported(rough, register)).moved(poses)

    np.testing.assert_allclose(moved_by(lambda one: exact[one.ends])[5], at(TWIN_M + 0.32), atol=1e-12)
    assert not moved_by(lambda _: None)
    assert not moved_by(lambda one: replace(one, edge=PoseEdge(*one.ends, at(3.0), np.eye(6)), is_registered=True))


def test_the_way_of_the_camera_holds_a_picture():
    way = [replace(one, is_next=one.edge.a == 0 and one.edge.b == 5) for one in ties(1, 3)]
    assert not moved(way, {**POSES, 5: at(0.3)})


@pytest.mark.parametrize("gap_s", [0.5, 10.0])
def test_a_picture_moves_nowhere_where_the_camera_could_not_have_been_in_time(gap_s):
    """It was never faster than a metre a second, and took another picture, a while before, at the place here."""
    keyframes = [SimpleNamespace(view=SimpleNamespace(stamp=n * gap_s)) for n in range(13)]
    step = replace(pair(0, 1, gap_s), is_next=True)
    poses, reassignment = {**POSES, 4: at(0.2), 5: at(0.3)}, told(ties(1, 3))
    reassignment.pairs.speed = CameraSpeed(keyframes, [step])
    assert list(reassignment.moved(poses)) == ([5] if gap_s > 5 else [])
    undecided = told(ties(3, 2))
    undecided.pairs.speed = reassignment.pairs.speed
    assert undecided.undecided(poses) == ([5] if gap_s > 5 else [])


@pytest.mark.parametrize(
    ("here", "there", "is_undecided"),
    [
        (FITS, FITS, True),
        (PlacementFit(0.0, 0.3), PlacementFit(0.0, 0.9), True),  # both differ less than is usual
        (PlacementFit(0.0, None), PlacementFit(0.0, 3.0), True),
        (PlacementFit(0.0, 1.0), PlacementFit(0.0, 3.0), False),
        (FITS, PlacementFit(0.2, 1.0), False),
        (FITS, PlacementFit(0.07, 1.0), True),  # hardly more than may be contradicted where it belongs
    ],
)
def test_what_fits_two_places_alike_is_undecided_however_many_ties_hold_it(here, there, is_undecided):
    poses = {**POSES, 5: at(0.3)}
    assert told(ties(3, 2), here, there).undecided(poses) == ([5] if is_undecided else [])
    assert not told(ties(3, 0), here, there).undecided(poses)
    way = [replace(one, is_next=one.edge.a == 0 and one.edge.b == 5) for one in ties(3, 2)]
    assert not told(way, here, there).undecided(poses)


def test_of_several_that_lie_wrong_the_one_draws_the_other():
    """5 and 6 hold each other here; of 6 nothing but 5 says where it lies."""
    pairs = [*ties(1, 3), pair(5, 6, 0.1, 90)]
    pairs = [replace(one, score=1.0) if one.edge.b in (10, 11, 12) else one for one in pairs]
    found = moved(pairs, {**POSES, 5: at(0.3), 6: at(0.4)}, PlacementFit(0.0, 2.5), FITS)
    assert list(found) == [5, 6]
    np.testing.assert_allclose(found[6], at(TWIN_M + 0.4), atol=1e-12)


def test_what_is_undecided_is_parted_from_the_rest_unless_it_holds_that_together(monkeypatch):
    """Two triangles that picture 2 has in common."""
    monkeypatch.setattr(Reassignment, "_fit", lambda *_: FITS)
    ends = [(0, 1), (0, 2), (1, 2), (2, 3), (2, 4), (3, 4)]
    parts = parts_of([pair(a, b, 0.1 * (b - a)) for a, b in ends], 5)
    monkeypatch.setattr(parts, "_is_contradicted", lambda *_: False)
    parts.grow()
    parts.leave_undecided()
    assert sorted(map(sorted, parts.members.values())) == [[0, 1, 2, 3, 4]]
    monkeypatch.setattr(Reassignment, "undecided", lambda *_: [0, 2, 3, 4])
    parts.leave_undecided()
    assert sorted(map(sorted, parts.members.values())) == [[0], [1, 2], [3], [4]]
    assert parts.part_of == [0, 1, 1, 3, 4]


@pytest.mark.parametrize(("n_rest", "n_hanging", "goes"), [(12, 3, True), (12, 4, False), (11, 3, False), (4, 1, True)])
def test_a_few_that_hang_by_an_undecided_picture_go_with_it(monkeypatch, n_rest, n_hanging, goes):
    """A row of pictures, the last ones beyond the undecided one."""
    monkeypatch.setattr(Reassignment, "_fit", lambda *_: FITS)
    n = n_rest + 1 + n_hanging
    parts = parts_of([pair(a, a + 1, 0.1) for a in range(n - 1)], n)
    monkeypatch.setattr(parts, "_is_contradicted", lambda *_: False)
    parts.grow()
    monkeypatch.setattr(Reassignment, "undecided", lambda _, poses: [n_rest] if n_rest in poses else [])
    assert parts.leave_undecided() == goes
    sizes = [n_rest, 1, n_hanging] if goes else [n]
    assert sorted(map(len, parts.members.values())) == sorted(sizes)
    assert not parts.leave_undecided()


def test_what_lay_beside_an_undecided_picture_is_asked_again(monkeypatch):
    """Of a row whose last picture is undecided, and the one before once that is out."""
    monkeypatch.setattr(Reassignment, "_fit", lambda *_: FITS)
    parts = parts_of([pair(a, a + 1, 0.1) for a in range(11)], 12)
    monkeypatch.setattr(parts, "_is_contradicted", lambda *_: False)
    monkeypatch.setattr(parts, "reassign", lambda: False)
    monkeypatch.setattr(parts, "part_look_alikes", lambda: False)
    monkeypatch.setattr(Reassignment, "undecided", lambda _, poses: [max(poses)] * (max(poses) in (10, 11)))
    parts.settle()
    assert sorted(map(sorted, parts.members.values())) == [[*range(10)], [10], [11]]


def test_pictures_that_moved_are_smoothed_where_they_are_and_what_is_left_is_parted(monkeypatch):
    """Two places that only a picture between them held together, which lies at one of them."""
    monkeypatch.setattr(Reassignment, "_fit", lambda *_: FITS)
    parts = parts_of(TWO_PLACES, 7)
    monkeypatch.setattr(parts, "_is_contradicted", lambda *_: False)
    parts.grow()
    assert sorted(map(sorted, parts.members.values())) == [[0, 1, 2], [3, 4, 5], [6]]
    further = [pair(0, 6, 0.3), *(pair(n, 6, 0.9 - 0.1 * n) for n in (3, 4, 5))]
    parts._pairs = KnownPairs([None] * 7, [*TWO_PLACES, *further], SlamConfig())
    parts._pairs.supported = parts._pairs.by_number
    for other, x_m in ((part, x) for part, x in ((parts.part_of[3], TWIN_M), (6, 0.3))):
        parts._join(parts.part_of[0], other, at(x_m) @ np.linalg.inv(parts.poses[3 if other != 6 else 6]))
    assert parts.reassign()
    assert sorted(map(sorted, parts.members.values())) == [[0, 1, 2], [3, 4, 5, 6]]
    np.testing.assert_allclose(np.linalg.inv(parts.poses[3]) @ parts.poses[6], at(0.6), atol=1e-6)


def test_pairs_that_triangles_speak_against_move_nothing(monkeypatch):
    """Picture 6 lies where one pair puts it; three say that it lies at the other place."""
    monkeypatch.setattr(Reassignment, "_fit", lambda *_: FITS)
    there = [pair(n, 6, 0.9 - 0.1 * n) for n in (3, 4, 5)]
    parts = parts_of([*TWO_PLACES, pair(0, 6, 0.3), *there], 7)
    poses = {n: at(x_m) for n, x_m in enumerate([0.0, 0.1, 0.2, TWIN_M, TWIN_M + 0.1, TWIN_M + 0.2, 0.3])}
    assert list(parts._reassignment.moved(poses)) == [6]
    against = {one.ends for one in there}
    monkeypatch.setattr(
        "slam.sparse.known_pairs.pair_support", lambda pairs, *_: {p.ends: -10.0 * (p.ends in against) for p in pairs}
    )
    parts = parts_of([*TWO_PLACES, pair(0, 6, 0.3), *there], 7)
    assert not parts._reassignment.moved(poses)


class Compared(NamedTuple):
    """Two pictures that are half a separation apart, and how their colours differ."""

    difference: ColorDifference | None
    separation: float = 0.5

    def color_difference(self, _):
        return self.difference


def test_pictures_count_by_the_readings_that_they_share():
    """Three that show the rim of what a picture shows, one that shows all of it, and one that shows nothing of it."""
    rim, whole = Compared(ColorDifference(0.2, 100)), Compared(ColorDifference(0.0, 4700))
    reassignment, usual = Reassignment(None, supported([]), SlamConfig()), USUAL.at([0.5])[0]
    excess = reassignment._color_excess([rim, rim, rim, whole, Compared(None)])
    assert excess == pytest.approx(3 * 20 / 5000 / usual)
    assert reassignment._color_excess([Compared(None)]) is None


def test_a_picture_fits_where_it_was_taken_and_not_elsewhere():
    room, config, keyframes = SyntheticScene("room", 3, 60, sensor=SensorModel.kinect()), SlamConfig(), Keyframes()
    extractor, calibration = FeatureExtractor(config), ColorCalibration.nominal()
    numbers = (10, 12, 14, 16)
    for index in numbers:
        view = View.of(room[index], extractor.extract(room[index], calibration), STILL, config)
        keyframes.add(view, np.eye(4), 0, 0.0)
    poses = {n: room[index].pose for n, index in enumerate(numbers)}
    reassignment = Reassignment(PlacedPictures(keyframes, config.free_space), supported([]), config)
    right = reassignment._fit(3, poses[3], poses)
    wrong = reassignment._fit(3, poses[3] @ exp_se3(np.array([0, 0.3, 0, 0.5, 0, 0])), poses)
    assert right.contradiction < config.submaps.max_contradiction < wrong.contradiction
    assert right.color_excess < 1
    assert right.is_clearly_better(wrong)
