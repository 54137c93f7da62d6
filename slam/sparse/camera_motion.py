"""Camera motion: how a camera was carried that took pictures one after the other.

How fast says how far apart pictures can lie that follow each other: a place that looks like another is seldom next to
it. How it turned says what it did to them while they were taken.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

import numpy as np

from razer.arrays import Float64Array
from slam.frontend.frame_tracker import MAX_GAP_S, MAX_TURNING_RAD_S, MIN_GAP_S
from slam.frontend.keyframes import Keyframes
from slam.pose_edge import PoseEdge
from slam.se3 import angle_deg, length_m, turn_rad
from slam.sparse.measured_pair import MeasuredPair

# Of a kitchen at 2 to 15 pictures a second and of a camera that turns fast 0.87 to 1, of these shuffled, 25 or more, at
# most 0.71.
STEADY = 0.75
TIMES_FASTEST, SLACK_M = 3.0, 0.5  # of what was measured: people stop, and hurry; and what poses may be off


class CameraSpeed:
    """The greatest speed of a recording, by its pairs of pictures that follow each other; any, where there are none.

    Args:
        keyframes: the pictures, in the order of their stamps.
        pairs: those that were measured.
    """

    def __init__(self, keyframes: Keyframes, pairs: Iterable[MeasuredPair]) -> None:
        self._keyframes = keyframes
        measured = [(length_m(pair.edge.a_from_b), self._gap_s(*pair.ends)) for pair in pairs if pair.is_next]
        self.fastest_m_per_s = max((way_m / gap_s for way_m, gap_s in measured if gap_s > 0), default=np.inf)

    def _gap_s(self, a: int, b: int) -> float:
        return abs(self._keyframes[b].view.stamp - self._keyframes[a].view.stamp)

    def is_exceeded(self, first: Mapping[int, Float64Array], second: Mapping[int, Float64Array]) -> bool:
        """Whether a picture of one set would have to be reached too fast from the one before it in the other.

        Args:
            first: poses (4, 4) of some pictures, by number.
            second: those of others; where it has one of the first ones, too, that is not looked at.
        """
        if np.isinf(self.fastest_m_per_s):
            return False
        poses = {**second, **first}
        return any(self._is_too_far(a, b, poses) for a, b in pairwise(sorted(poses)) if (a in first) != (b in first))

    def _is_too_far(self, a: int, b: int, poses: Mapping[int, Float64Array]) -> bool:
        way_m, gap_s = float(np.linalg.norm(poses[a][:3, 3] - poses[b][:3, 3])), self._gap_s(a, b)
        return gap_s > 0 and way_m > TIMES_FASTEST * self.fastest_m_per_s * gap_s + SLACK_M


def turning_rad_s(keyframes: Keyframes, edges: Sequence[PoseEdge]) -> dict[int, Float64Array]:
    """How the camera turned (3,), about its own axes, at pictures by number: the mean of what the edges to the one
    before and to the one after say, of those where little time lies between; nothing of pictures that are in no order.

    Args:
        keyframes: the pictures, in the order of their stamps.
        edges: between such that follow each other, in this order.
    """
    told = defaultdict[int, list[Float64Array]](list)
    for edge in edges if steadiness(edges) >= STEADY else ():
        gap_s = keyframes[edge.b].view.stamp - keyframes[edge.a].view.stamp
        # About the axis of the motion, which both cameras see alike.
        turning = turn_rad(edge.a_from_b) / max(gap_s, MIN_GAP_S)
        if MIN_GAP_S <= gap_s <= MAX_GAP_S and np.linalg.norm(turning) <= MAX_TURNING_RAD_S:
            told[edge.a].append(turning)
            told[edge.b].append(turning)
    return {number: np.mean(each, axis=0) for number, each in told.items()}


def steadiness(edges: Sequence[PoseEdge]) -> float:
    """By how much of the angles of two steps a camera turned over both of them: all if it goes on to turn as before,
    half if pictures come in no order, as the next then looks anywhere. All where no two steps follow each other.

    Args:
        edges: between pictures that follow each other, in this order.
    """
    steps = [(one, next_one) for one, next_one in pairwise(edges) if one.b == next_one.a]
    over_both = sum(angle_deg(one.a_from_b @ next_one.a_from_b) for one, next_one in steps)
    each = sum(angle_deg(one.a_from_b) + angle_deg(next_one.a_from_b) for one, next_one in steps)
    return over_both / each if each else 1.0
