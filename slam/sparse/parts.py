"""Parts: pictures whose poses relative to each other are known, grown from the surest pairs (Kruskal, 1956), where
every further pair is tested against what is known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.free_space_check import contradiction
from slam.backend.pose_graph import PoseGraph
from slam.backend.submaps.merge_hypotheses import MAJORITY, SAME_DEG, SAME_M
from slam.backend.view_overlap import near_poses
from slam.config import SlamConfig
from slam.frontend.keyframes import Keyframes
from slam.pose_edge import PoseEdge
from slam.se3 import angle_deg, length_m
from slam.sparse.measured_pair import MeasuredPair, by_picture, surest_first

ALONE_FEATURES = 20  # that agree, for a single pair to join two parts: fewer may agree on a look-alike
MOST_COMPARED = 60  # pairs of pictures whose free space is compared before two parts are joined
SMOOTH_FROM = 3  # pictures of the smaller part from which joining two bends both


class Parts:
    """The parts that pictures fall into; in the beginning each is one."""

    def __init__(self, keyframes: Keyframes, pairs: Sequence[MeasuredPair], config: SlamConfig) -> None:
        self._keyframes, self._config = keyframes, config
        self._pairs = surest_first(pairs)
        self._table = by_picture(self._pairs)
        self.part_of = list(range(len(keyframes)))
        self.members: dict[int, list[int]] = {n: [n] for n in self.part_of}
        self.poses: dict[int, Float64Array] = {n: np.eye(4) for n in self.part_of}
        self._version = [0] * len(keyframes)  # of each part, so that nothing is tested twice
        self._tested: dict[tuple[int, int], tuple[int, int]] = {}

    def grow(self) -> None:
        """Join parts until nothing is left that may be joined."""
        while sum(self._try(pair) for pair in self._pairs):
            pass

    def agreeing(self, part: int) -> list[MeasuredPair]:
        """The pairs within a part that its poses bear out."""
        inside = [p for p in self._pairs if self.part_of[p.edge.a] == self.part_of[p.edge.b] == part]
        return [p for p in inside if _same(self._between(p.edge.a, p.edge.b), p.edge.a_from_b)]

    def _between(self, a: int, b: int) -> Float64Array:
        return inverse(self.poses[a]) @ self.poses[b]

    def _try(self, pair: MeasuredPair) -> bool:
        """Join the parts that a pair ties together, if that is sure enough."""
        home, away = sorted((self.part_of[pair.edge.a], self.part_of[pair.edge.b]), key=self._rank)
        versions = self._version[home], self._version[away]
        if home == away or self._tested.get((home, away)) == versions:
            return False
        ties = self._ties(home, away)
        motion = self._agreed(ties)
        if motion is None or self._is_contradicted(home, away, motion):
            self._tested[home, away] = versions
            return False
        self._join(home, away, motion)
        return True

    def _rank(self, part: int) -> tuple[int, int]:
        return -len(self.members[part]), part

    def _ties(self, home: int, away: int) -> list[tuple[MeasuredPair, Float64Array]]:
        """The pairs between two parts, and home_from_away (4, 4) as each has it, the surest first."""
        ties = []
        for n in self.members[away]:
            for other, pair in self._table.get(n, {}).items():
                if self.part_of[other] == home:
                    ties.append((pair, self.poses[other] @ pair.motion(other) @ inverse(self.poses[n])))
        return sorted(ties, key=lambda tie: -tie[0].n_features * tie[0].score)

    def _agreed(self, ties: Sequence[tuple[MeasuredPair, Float64Array]]) -> Float64Array | None:
        """home_from_away as most ties have it; None where they are not sure enough, or too many say otherwise."""
        groups = [[other for other in ties if _same(motion, other[1])] for _, motion in ties]
        best = max(groups, key=len)
        against = [tie for tie in ties if not any(tie is one for one in best)]
        rival = max((sum(_same(motion, other) for _, other in against) for _, motion in against), default=0)
        if len(best) < MAJORITY * rival:
            return None
        surest = best[0][0]
        is_sure = len(best) > 1 or surest.is_next or surest.n_features >= ALONE_FEATURES
        return best[0][1] if is_sure else None

    def _is_contradicted(self, home: int, away: int, home_from_away: Float64Array) -> bool:
        """Whether pictures of one part, put where ties say, would show what stands where those of the other saw
        through."""
        at_home = np.array(self.members[home])
        poses, against = np.stack([self.poses[n] for n in self.members[home]]), list[float]()
        each = max(1, MOST_COMPARED // len(self.members[away]))
        for number in self.members[away]:
            moved = home_from_away @ self.poses[number]
            for other in at_home[near_poses(moved, poses, self._config.loop_closure)[:each]].tolist():
                against.append(self._contradiction(other, number, inverse(self.poses[other]) @ moved))
        return bool(against) and float(np.mean(against)) > self._config.submaps.max_contradiction

    def _contradiction(self, a: int, b: int, a_from_b: Float64Array) -> float:
        return contradiction(self._keyframes[a].view, self._keyframes[b].view, a_from_b, self._config.free_space)

    def _join(self, home: int, away: int, home_from_away: Float64Array) -> None:
        joined = self.members.pop(away)
        for number in joined:
            self.part_of[number] = home
            self.poses[number] = home_from_away @ self.poses[number]
        self.members[home] += joined
        self._version[home] += 1
        if len(joined) >= SMOOTH_FROM or len(self.members[home]) % SMOOTH_FROM == 0:
            numbers = sorted(self.members[home])
            edges = [pair.edge for pair in self.agreeing(home)]
            self.poses.update(smoothed({n: self.poses[n] for n in numbers}, edges))


def smoothed(poses: Mapping[int, Float64Array], edges: Sequence[PoseEdge]) -> Mapping[int, Float64Array]:
    """Poses (4, 4) by picture as all edges have them, the first one staying where it is."""
    graph = PoseGraph(fixed=min(poses))
    for number in sorted(poses):
        graph.add_keyframe(number, poses[number])
    for edge in edges:
        graph.add_edge(edge)
    return graph.smooth()


def _same(a: Float64Array, b: Float64Array) -> bool:
    offset = inverse(a) @ b
    return length_m(offset) <= SAME_M and angle_deg(offset) <= SAME_DEG
