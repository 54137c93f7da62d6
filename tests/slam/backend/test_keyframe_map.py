"""Which keyframes a view of an unanchored submap is compared with, and what becomes of doubtful odometry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from slam.backend.keyframe_map import KeyframeMap
from slam.backend.loop_closure import RECENT
from slam.backend.pose_graph import PoseEdge
from slam.backend.submaps.chain_ties import hanging_on
from slam.backend.submaps.submap_search import Candidate
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.keyframes import LocatedView
from slam.frontend.view_registration import ViewRegistration
from slam.se3 import exp_se3
from slam.uncertainty.pose_uncertainty import final_uncertainty

NOMINAL = ColorCalibration.nominal()
AT_X_M = (0.0, 0.1, 10.0)  # keyframes of the world: two of one place, and one of another that looks alike


def at(x_m):
    return exp_se3(np.array([0, 0, 0, x_m, 0, 0]))


@pytest.fixture
def compared(views, monkeypatch):
    """A submap's view, which every keyframe is said to show, and what it was compared with where some are found."""
    slam = KeyframeMap(SlamConfig())
    world = [slam.place(replace(views[10], index=n), at(x_m), 0.0, [], []) for n, x_m in enumerate(AT_X_M)]
    first = slam.begin_submap(views[12], 0.0)
    fits = ViewRegistration(SlamConfig()).register(views[10], views[12], [np.eye(4)], NOMINAL)

    def of(found_in):
        asked = []

        def recognise(keyframe, *_):
            asked.append(keyframe.number)
            moved = at(AT_X_M[1] - AT_X_M[keyframe.number] if keyframe.number < 2 else 0.0)
            return replace(fits, target_from_source=moved) if keyframe.number in found_in else None

        monkeypatch.setattr(slam._registration, "recognise", recognise)
        candidates = [Candidate(keyframe.number, np.eye(4)) for keyframe in world]
        monkeypatch.setattr(slam._search, "next_candidates", lambda *_: candidates)
        monkeypatch.setattr(slam._search.local_map, "recognise", lambda *_: None)
        slam.search_submaps(LocatedView(views[12], first, np.eye(4)), NOMINAL)
        return asked

    return of


def test_a_view_that_was_found_is_not_found_once_more_at_the_same_place(compared):
    assert compared(found_in={0, 1, 2}) == [0, 2]


def test_where_a_view_was_not_found_the_next_keyframe_is_asked(compared):
    assert compared(found_in={1, 2}) == [0, 1, 2]


@pytest.mark.parametrize("off_m", [0.0, 0.02])
def test_odometry_is_registered_anew_where_loops_contradict_it(views, off_m):
    """Of two views the true motion is known; tracking measured it with an error, and loops say so."""
    slam = KeyframeMap(SlamConfig())
    a = slam.begin_submap(views[10], 0.0)
    fits = ViewRegistration(SlamConfig()).register(views[10], views[12], [np.eye(4)], NOMINAL)
    wrong = replace(fits, target_from_source=at(off_m) @ fits.target_from_source)
    b = slam.extend(a, views[12], wrong, 0.0)
    for _ in range(3):  # as if other views had measured it
        slam.graph.add_edge(PoseEdge(a.number, b.number, fits.target_from_source, fits.information))
    slam._optimise()
    before = slam.graph.edges[0]
    slam._remeasure_odometry(NOMINAL)
    after = next(edge for edge in slam.graph.edges if edge.is_odometry)
    assert (after is before) is (off_m == 0)
    assert len(slam.graph.edges) == 4
    np.testing.assert_allclose(after.a_from_b, fits.target_from_source, atol=1e-3)


def test_a_keyframe_belongs_to_the_odometry_chain_of_the_one_that_it_was_tracked_from(views):
    """The camera goes on in front of a known keyframe of before it was lost; what followed that is parted."""
    slam = KeyframeMap(SlamConfig())
    fits = ViewRegistration(SlamConfig()).register(views[10], views[12], [np.eye(4)], NOMINAL)
    first = slam.begin_submap(views[10], 0.0)
    second = slam.extend(first, views[12], fits, 0.0)
    resumed = slam.resume(second, views[12], fits, 0.0)
    third = slam.extend(resumed, views[12], fits, 0.0)
    fourth = slam.extend(second, views[12], fits, 0.0)
    assert slam.keyframes.chains().tolist() == [0, 0, 1, 1, 0]
    of_resumed = hanging_on(resumed.chain, slam.keyframes.chains(), slam.graph.edge_table()[0])
    assert of_resumed.tolist() == [resumed.number, third.number]
    slam._merging._part(of_resumed)
    assert len(final_uncertainty(slam.graph, 1.0).covariances) == fourth.number + 1


def test_what_tracking_measured_closes_no_loop_however_old_the_keyframe(views):
    slam = KeyframeMap(SlamConfig())
    fits = ViewRegistration(SlamConfig()).register(views[10], views[12], [np.eye(4)], NOMINAL)
    first = last = slam.begin_submap(views[10], 0.0)
    for _ in range(RECENT + 1):
        last = slam.extend(last, views[12], fits, 0.0)
    slam.extend(first, views[12], fits, 0.0)
    assert slam.n_loops == 0
    slam.graph.add_edge(PoseEdge(0, last.number, fits.target_from_source, fits.information))
    assert slam.n_loops == 1
