"""Where parts do not hang together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from slam.config import SlamConfig
from slam.pose_edge import PoseEdge
from slam.se3 import exp_se3
from slam.sparse.measured_pair import MeasuredPair
from slam.sparse.parts import Parts
from slam.sparse.weak_joint import weak_joint

TWIN_M = 5.0  # from one place to the other that looks alike


def at(x_m):
    return exp_se3(np.array([0, 0, 0, x_m, 0, 0]))


def pair(a, b, x_m, n_features=50):
    return MeasuredPair(PoseEdge(a, b, at(x_m), 1e6 * np.eye(6)), n_features, 0.5)


# Pictures 0 to 2 and 3 to 5 hang together; one pair joins the second three beside the first, others in the twin.
WITHIN = [pair(a, b, 0.1 * (b - a)) for a, b in [(0, 1), (0, 2), (1, 2), (3, 4), (3, 5), (4, 5)]]
JOINT = pair(2, 3, 0.1)
AGAINST = [pair(a, b, TWIN_M + 0.1 * (b - a)) for a, b in [(0, 3), (1, 4), (2, 4)]]
POSES = {n: at(0.1 * n) for n in range(6)}


def cut(pairs, of_joint=2.0, of_others=2.0):
    support = {one.ends: 4.0 for one in WITHIN} | {one.ends: of_others for one in AGAINST} | {JOINT.ends: of_joint}
    return weak_joint(pairs, POSES, support)


def test_what_twice_as_much_speaks_against_is_cut_there_and_nowhere_else():
    assert cut([*WITHIN, JOINT, *AGAINST]) in ({0, 1, 2}, {3, 4, 5})


@pytest.mark.parametrize(
    ("pairs", "of_others"),
    [
        ([*WITHIN, JOINT], 2.0),  # nothing speaks against it
        ([*WITHIN, JOINT, AGAINST[0]], 2.0),  # as much as holds it
        ([*WITHIN, JOINT, *AGAINST], -1.0),  # look-alikes, as triangles have it
        ([*WITHIN, replace(JOINT, is_next=True), *AGAINST], 2.0),  # the camera was carried from one to the next
        ([], 2.0),
    ],
    ids=["nothing", "as much", "unsupported", "next", "none"],
)
def test_what_holds_is_not_cut(pairs, of_others):
    assert cut(pairs, of_others=of_others) is None


def test_pairs_against_it_of_which_triangles_bear_out_few_cut_nothing():
    """Of twin rooms many pairs are false, and some of them pass for true ones."""
    support = {one.ends: 4.0 for one in WITHIN} | {one.ends: -4.0 for one in AGAINST} | {JOINT.ends: 0.2}
    support[AGAINST[0].ends] = 2.0
    assert weak_joint([*WITHIN, JOINT, *AGAINST], POSES, support) is None


def test_a_single_picture_is_left_to_move_by_itself():
    pairs = [
        pair(0, 1, 0.1),
        pair(0, 2, 0.2),
        pair(1, 2, 0.1),
        pair(2, 3, 0.1),
        pair(0, 3, TWIN_M),
        pair(1, 3, TWIN_M - 0.1),
    ]
    poses = {n: at(0.1 * n) for n in range(4)}
    assert weak_joint(pairs, poses, {one.ends: 2.0 for one in pairs}) is None


def test_a_part_that_was_joined_wrongly_is_parted_and_joined_anew(monkeypatch):
    """The joint is the surest pair between the two; together the others say more."""
    pairs = [*WITHIN, replace(JOINT, n_features=60), *AGAINST]
    parts = Parts([None] * 6, pairs, SlamConfig())
    monkeypatch.setattr(parts, "_is_contradicted", lambda *_: False)
    parts._support = {one.ends: 4.0 for one in pairs}
    for away in (1, 2):
        parts._join(0, away, at(0.1 * away))
    for away in (4, 5):
        parts._join(3, away, at(0.1 * (away - 3)))
    parts._join(0, 3, at(0.3))
    assert parts.cut()
    assert sorted(map(sorted, parts.members.values())) == [[0, 1, 2], [3, 4, 5]]
    assert not parts.cut()
    parts.grow()
    np.testing.assert_allclose(np.linalg.inv(parts.poses[0]) @ parts.poses[3], at(TWIN_M + 0.3), atol=0.02)
