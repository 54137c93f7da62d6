"""Parts: pictures whose poses relative to each other are known, grown from the surest pairs (Kruskal, 1956), where
every further pair is tested against what is known."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from razer.arrays import BoolArray, Float64Array, IndexArray
from razer.geometry import inverse
from slam.backend.pose_graph import PoseGraph
from slam.backend.submaps.merge_hypotheses import MAJORITY, SAME_DEG, SAME_M, same_motions
from slam.backend.submaps.placement_check import PlacedPair, contradict
from slam.backend.view_checks.usual_colors import UsualColors
from slam.backend.view_overlap import near_poses
from slam.config import SlamConfig
from slam.frontend.keyframes import Keyframes
from slam.pose_edge import PoseEdge
from slam.sparse.measured_pair import MeasuredPair, Numbers, by_picture, is_sure, surest_first
from slam.sparse.missing_pairs import missing_pairs
from slam.sparse.pair_support import pair_support
from slam.sparse.placed_pictures import PlacedPictures
from slam.sparse.reassignment import Reassignment

MOST_TESTED = 10  # groups of ties between two parts: there are few look-alikes of any, but some false ties with each
# Of ties on average: those of one place have -3 and more, as through doors; those of two, -5 to -20.
LEAST_SUPPORT = -5.0
# Times the other colours that two parts may have on the whole: ties are few, and mostly edges, as through doors.
FEW_TIMES = 2.0
MOST_COMPARED = 60  # pairs of pictures whose free space is compared before two parts are joined
ROUNDS = 5  # of moving pictures and joining what that leaves, at most: some move to and fro
SMOOTH_FROM = 3  # pictures of the smaller part from which joining two bends both


class Parts:
    """The parts that pictures fall into; in the beginning each is one.

    Args:
        keyframes: the pictures.
        pairs: those that were measured.
        config: the settings.
        unrecognised: the pairs that were compared in vain.
    """

    def __init__(
        self,
        keyframes: Keyframes,
        pairs: Sequence[MeasuredPair],
        config: SlamConfig,
        unrecognised: Collection[Numbers] = (),
    ) -> None:
        self._keyframes, self._config = keyframes, config
        self._table, self._usual_colors = by_picture(pairs), _usual_colors(pairs)
        missing = missing_pairs(keyframes, pairs, unrecognised, config.depth.max_depth_m)
        self._support = pair_support(pairs, self._usual_colors, missing)
        self._pairs = surest_first(pairs, self._support)
        self._supported = by_picture([pair for pair in pairs if not self._is_unsupported([pair])])
        self._placed = PlacedPictures(keyframes, config.free_space)
        self.part_of = list(range(len(keyframes)))
        self.members: dict[int, list[int]] = {n: [n] for n in self.part_of}
        self.poses: dict[int, Float64Array] = {n: np.eye(4) for n in self.part_of}
        self._version = [0] * len(keyframes)  # of each part, so that nothing is tested twice
        self._tested: dict[tuple[int, int], tuple[int, int]] = {}

    @classmethod
    def of(
        cls,
        keyframes: Keyframes,
        pairs: Sequence[MeasuredPair],
        config: SlamConfig,
        unrecognised: Collection[Numbers] = (),
    ) -> Parts:
        """Those that pictures fall into in the end."""
        parts = cls(keyframes, pairs, config, unrecognised)
        parts.grow()
        for _ in range(ROUNDS):
            if not parts.reassign():
                break
            parts.grow()
        parts.leave_undecided()
        return parts

    def grow(self) -> None:
        """Join parts until nothing is left that may be joined."""
        while sum(self._try(pair) for pair in self._pairs):
            pass

    def reassign(self) -> bool:
        """Move pictures that lie in the wrong one of two look-alike places to the other, part what that leaves without
        a tie, and say whether any was moved."""
        return sum(self._reassign(part) for part in sorted(self.members)) > 0

    def leave_undecided(self) -> None:
        """Part what might as well lie in another place from the rest; but not what holds the rest together, which says
        from two sides where it lies."""
        for part in sorted(self.members):
            alone, n_parts = list[int](), 1
            for number in self._reassignment.undecided(self._poses_of(part)):
                if len(self._tied_together(part, [*alone, number])) == n_parts + 1:
                    alone, n_parts = [*alone, number], n_parts + 1
            if alone:
                self._split(part, alone)

    @property
    def _reassignment(self) -> Reassignment:
        return Reassignment(self._placed, self._supported, self._usual_colors, self._config)

    def _reassign(self, part: int) -> bool:
        moved = self._reassignment.moved(self._poses_of(part))
        if moved:
            self.poses.update(moved)
            self._split(part)
        return bool(moved)

    def _poses_of(self, part: int) -> dict[int, Float64Array]:
        return {n: self.poses[n] for n in self.members[part]}

    def _split(self, part: int, alone: Sequence[int] = ()) -> None:
        """Part what no pair ties together, but for those of some pictures."""
        tied = self._tied_together(part, alone)
        del self.members[part]
        for numbers in tied:
            self._set_apart(numbers)
        for numbers in tied:
            self._smooth(min(numbers))

    def _tied_together(self, part: int, alone: Sequence[int]) -> list[list[int]]:
        """The numbers of a part's pictures, by what pairs that its poses bear out tie together."""
        edges = [pair.edge for pair in self.agreeing(part) if not {pair.edge.a, pair.edge.b} & {*alone}]
        tied = components(len(self._keyframes), edges)[self.members[part]]
        return [[n for n, t in zip(self.members[part], tied, strict=True) if t == one] for one in np.unique(tied)]

    def _set_apart(self, numbers: list[int]) -> None:
        """Pictures as a part of their own."""
        part = min(numbers)
        for n in numbers:
            self.part_of[n] = part
        self.members[part] = numbers
        self._version[part] += 1

    def agreeing(self, part: int) -> list[MeasuredPair]:
        """The pairs within a part that its poses bear out."""
        inside = [p for p in self._pairs if self.part_of[p.edge.a] == self.part_of[p.edge.b] == part]
        if not inside:
            return []
        first, second = (
            np.stack([self.poses[n] for n in ends]) for ends in zip(*(p.ends for p in inside), strict=True)
        )
        told = first @ np.stack([p.edge.a_from_b for p in inside])
        return [pair for pair, is_same in zip(inside, _same(told, second), strict=True) if is_same]

    def _try(self, pair: MeasuredPair) -> bool:
        """Join the parts that a pair ties together, if that is sure enough."""
        home, away = sorted((self.part_of[pair.edge.a], self.part_of[pair.edge.b]), key=self._rank)
        versions = self._version[home], self._version[away]
        if home == away or self._tested.get((home, away)) == versions:
            return False
        motion = self._agreed(home, away)
        if motion is None:
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
        return sorted(ties, key=lambda tie: -tie[0].weight)

    def _agreed(self, home: int, away: int) -> Float64Array | None:
        """home_from_away as most ties have it that what the pictures saw bears out; None where those are not sure
        enough, or too many say otherwise."""
        ties = self._ties(home, away)
        motions = np.stack([motion for _, motion in ties])
        same, left = same_motions(motions, np.zeros(3)), np.ones(len(ties), bool)
        for _ in range(MOST_TESTED):
            best = _largest(same, left)
            if not is_sure([ties[n][0] for n in best]):
                return None
            rivals = _largest(same, left & ~np.isin(np.arange(len(ties)), best))
            if self._is_refuted(home, away, [ties[n] for n in best]):
                left[best] = False
            elif len(best) >= MAJORITY * len(rivals):
                return motions[best[0]]
            elif self._is_refuted(home, away, [ties[n] for n in rivals]):
                left[rivals] = False
            else:
                return None
        return None

    def _is_refuted(self, home: int, away: int, ties: Sequence[tuple[MeasuredPair, Float64Array]]) -> bool:
        """Whether ties that agree are of places that look alike."""
        pairs, home_from_away = [pair for pair, _ in ties], ties[0][1]
        is_told = self._is_unsupported(pairs) or self._have_other_colors(pairs)
        return is_told or self._is_contradicted(home, away, home_from_away)

    def _is_unsupported(self, ties: Sequence[MeasuredPair]) -> bool:
        """Whether other pairs say that ties put one place on another that looks alike."""
        if any(tie.is_next for tie in ties):
            return False
        support = np.average([self._support[tie.ends] for tie in ties], weights=[tie.weight for tie in ties])
        return bool(support < LEAST_SUPPORT)

    def _have_other_colors(self, ties: Sequence[MeasuredPair]) -> bool:
        """Whether pictures that ties put on each other differ far more in colour than pictures so far apart do: enough
        where no third picture shows what both do, so that there are no triangles."""
        usual = self._usual_colors.at([tie.separation for tie in ties])
        excess = float(np.mean([tie.other_colors for tie in ties])) / float(usual.mean())
        return excess > FEW_TIMES * self._config.submaps.max_color_excess

    def _is_contradicted(self, home: int, away: int, home_from_away: Float64Array) -> bool:
        """Whether pictures of one part, put where ties say, would show what stands where those of the other saw
        through, or has other colours."""
        pairs = self._near_pairs(home, away, home_from_away)
        return contradict(
            pairs, lambda shared: self._usual_colors.at([pair.separation for pair in shared]), self._config
        )

    def _near_pairs(self, home: int, away: int, home_from_away: Float64Array) -> list[PlacedPair]:
        """Pictures of two parts that would be near each other; of many, some."""
        at_home = np.array(self.members[home])
        poses, pairs = np.stack([self.poses[n] for n in self.members[home]]), list[PlacedPair]()
        for number in self.members[away]:
            moved = home_from_away @ self.poses[number]
            near = at_home[near_poses(moved, poses, self._config.loop_closure)]
            for other in near[near != number].tolist():
                pairs.append(self._placed.pair(other, number, inverse(self.poses[other]) @ moved))
        return pairs[:: -(-len(pairs) // MOST_COMPARED) or 1]

    def _join(self, home: int, away: int, home_from_away: Float64Array) -> None:
        joined = self.members.pop(away)
        for number in joined:
            self.part_of[number] = home
            self.poses[number] = home_from_away @ self.poses[number]
        self.members[home] += joined
        self._version[home] += 1
        if len(joined) >= SMOOTH_FROM or len(self.members[home]) % SMOOTH_FROM == 0:
            self._smooth(home)

    def _smooth(self, part: int) -> None:
        edges = [pair.edge for pair in self.agreeing(part)]
        self.poses.update(smoothed({n: self.poses[n] for n in sorted(self.members[part])}, edges))


def smoothed(poses: Mapping[int, Float64Array], edges: Sequence[PoseEdge]) -> Mapping[int, Float64Array]:
    """Poses (4, 4) by picture as all edges have them, the first one staying where it is."""
    graph = PoseGraph(fixed=min(poses))
    for number in sorted(poses):
        graph.add_keyframe(number, poses[number])
    for edge in edges:
        graph.add_edge(edge)
    return graph.smooth()


def _usual_colors(pairs: Sequence[MeasuredPair]) -> UsualColors:
    return UsualColors([pair.separation for pair in pairs], [pair.other_colors for pair in pairs])


def _largest(same: BoolArray, left: BoolArray) -> IndexArray:
    """Numbers, of those that are left (N,), of the largest group that is the same (N, N) as one of them."""
    sizes = np.where(left, (same & left).sum(axis=1), 0)
    return np.flatnonzero(same[int(np.argmax(sizes))] & left)


def _same(first: Float64Array, second: Float64Array) -> BoolArray:
    """Which poses (N, 4, 4) are the same as others, but for drift (N,)."""
    away_m = np.linalg.norm(first[:, :3, 3] - second[:, :3, 3], axis=1)
    cosine = (np.einsum("nij,nij->n", first[:, :3, :3], second[:, :3, :3]) - 1) / 2
    same: BoolArray = (away_m <= SAME_M) & (cosine >= np.cos(np.radians(SAME_DEG)))
    return same


def components(n_keyframes: int, edges: Sequence[PoseEdge]) -> IndexArray:
    """Which keyframes (K,) edges tie together, by the number of their component."""
    ends = np.array([(edge.a, edge.b) for edge in edges], np.int64).reshape(-1, 2)
    table = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(n_keyframes, n_keyframes))
    return connected_components(table, directed=False)[1].astype(np.intp)
