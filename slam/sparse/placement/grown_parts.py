"""Grown parts: pictures whose poses relative to each other are known, from the surest pairs (Kruskal, 1956), where each
further pair is tested against what is known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from razer.arrays import BoolArray, Float64Array, IndexArray
from razer.geometry import inverse
from slam.backend.submaps.merge_hypotheses import MAJORITY, SAME_DEG, SAME_M, same_motions
from slam.backend.submaps.placement_check import PlacedPair, UsualDifferences, contradict
from slam.backend.view_overlap import near_poses
from slam.config import SlamConfig
from slam.frontend.keyframes import Keyframes
from slam.sparse.known_pairs import KnownPairs
from slam.sparse.measured_pair import MeasuredPair, is_sure
from slam.sparse.pair_graph import smoothed
from slam.sparse.placement.placed_pictures import PlacedPictures
from slam.sparse.placement.reassignment import Tie

MOST_TESTED = 10  # groups of ties between two parts: there are few look-alikes of any, but some false ties with each
# Pairs of pictures whose free space is compared before two parts are joined: of each of the smaller one, and of all.
MOST_COMPARED_EACH, MOST_COMPARED = 16, 60
MOST_REGISTERED = 3  # of ties that agree, before something rests on them
SMOOTH_FROM = 3  # pictures of the smaller part from which joining two bends both


class GrownParts:
    """The parts that pictures fall into; in the beginning each is one.

    Args:
        keyframes: the pictures.
        pairs: what is known of them.
        config: the settings.
    """

    def __init__(self, keyframes: Keyframes, pairs: KnownPairs, config: SlamConfig) -> None:
        self._keyframes, self._pairs, self._config = keyframes, pairs, config
        self._placed = PlacedPictures(keyframes, config.free_space)
        self.part_of = list(range(len(keyframes)))
        self.members: dict[int, list[int]] = {n: [n] for n in self.part_of}
        self.poses: dict[int, Float64Array] = {n: np.eye(4) for n in self.part_of}
        self._version = [0] * len(keyframes)  # of each part, so that nothing is tested twice
        self._tested: dict[tuple[int, int], tuple[int, int]] = {}

    def learn(self, pairs: KnownPairs) -> None:
        """Go on with what is known by now."""
        self._pairs = pairs
        self._tested.clear()

    def grow(self) -> None:
        """Join parts until nothing is left that may be joined."""
        while sum(self._try(pair) for pair in list(self._pairs)):
            pass

    def agreeing(self, part: int) -> list[MeasuredPair]:
        """The pairs within a part that its poses bear out."""
        inside = [p for p in self._pairs if self.part_of[p.edge.a] == self.part_of[p.edge.b] == part]
        if not inside:
            return []
        first, second = (
            np.stack([self.poses[n] for n in ends]) for ends in zip(*(p.ends for p in inside), strict=True)
        )
        told = first @ np.stack([p.edge.a_from_b for p in inside])
        return [pair for pair, is_same in zip(inside, same_poses(told, second), strict=True) if is_same]

    def _poses_of(self, part: int) -> dict[int, Float64Array]:
        return {n: self.poses[n] for n in self.members[part]}

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

    def _ties(self, home: int, away: int) -> list[Tie]:
        """The pairs between two parts, and home_from_away (4, 4) as each has it, the surest first."""
        ties = []
        for n in self.members[away]:
            for other, pair in self._pairs.by_number.get(n, {}).items():
                if self.part_of[other] == home:
                    ties.append((pair, self._motion(pair, other)))
        return sorted(ties, key=lambda tie: -tie[0].weight)

    def _motion(self, pair: MeasuredPair, at_home: int) -> Float64Array:
        """home_from_away as a pair has it, of which one picture is at home."""
        return self.poses[at_home] @ pair.motion(at_home) @ inverse(self.poses[pair.other(at_home)])

    def _agreed(self, home: int, away: int) -> Float64Array | None:
        """home_from_away as most ties have it that what the pictures saw bears out; None where those are not sure
        enough, or too many say otherwise."""
        ties = self._ties(home, away)
        if not ties:
            return None
        same = same_motions(np.stack([motion for _, motion in ties]), np.zeros(3))
        votes = np.array([self._pairs.vote(pair) for pair, _ in ties])
        for _ in range(MOST_TESTED):
            best = _strongest(same, votes)
            if not is_sure([ties[n][0] for n in best]):
                left = [ties[n][0] for n in np.flatnonzero(votes)]
                return self._agreed(home, away) if self._register_best(left) else None
            rivals = _strongest(same, np.where(np.isin(np.arange(len(ties)), best), 0.0, votes))
            motion = self._borne_out(home, away, [ties[n] for n in best])
            if motion is None:
                votes[best] = 0.0
            elif votes[best].sum() >= MAJORITY * votes[rivals].sum():
                return motion
            elif self._borne_out(home, away, [ties[n] for n in rivals]) is None:
                votes[rivals] = 0.0
            else:
                return None
        return None

    def _register_best(self, ties: Sequence[MeasuredPair]) -> bool:
        """Register the best of ties none of which is sure, as these may lie too roughly to agree, and say whether there
        was anything to register."""
        if len(ties) < 2:
            return False
        rough = [pair for pair in ties if not pair.is_registered and not self._pairs.are_unsupported([pair])]
        for pair in rough[:MOST_REGISTERED]:
            self._pairs.registered(pair)
        return bool(rough)

    def _borne_out(self, home: int, away: int, ties: Sequence[Tie]) -> Float64Array | None:
        """home_from_away as ties that agree have it; None if they are of places that look alike."""
        pairs = [pair for pair, _ in ties]
        if self._pairs.are_unsupported(pairs) or self._pairs.have_other_colors(pairs):
            return None
        motion = self._settled(home, ties)
        return None if motion is None or self._is_contradicted(home, away, motion) else motion

    def _settled(self, home: int, ties: Sequence[Tie]) -> Float64Array | None:
        """home_from_away by the registrations of the best of ties that agree, the one that agrees with most; None where
        none agrees with any."""
        roughly, motions = np.stack([motion for _, motion in ties]), list[Float64Array]()
        for tie, _ in ties[:MOST_REGISTERED]:
            registered = self._pairs.registered(tie)
            if registered is not None:
                at_home = tie.edge.a if self.part_of[tie.edge.a] == home else tie.edge.b
                motions.append(self._motion(registered, at_home))
        if not motions:
            return None
        same = same_motions(np.concatenate([motions, roughly]), np.zeros(3))[: len(motions)]
        best = int(np.argmax(same.sum(axis=1)))
        return motions[best] if same[best].sum() > 1 else None

    def _is_contradicted(self, home: int, away: int, home_from_away: Float64Array) -> bool:
        """Whether pictures of one part, put where ties say, would show what stands where those of the other saw
        through, or has other colours, or follow each other faster than the camera was carried."""
        moved = {n: home_from_away @ self.poses[n] for n in self.members[away]}
        if self._pairs.speed.is_exceeded(self._poses_of(home), moved):
            return True
        pairs = self._near_pairs(home, moved)
        return contradict(pairs, self._usual_differences, self._config)

    def _usual_differences(self, pairs: Sequence[PlacedPair]) -> UsualDifferences:
        return UsualDifferences(self._pairs.usual_where_placed.at([pair.separation for pair in pairs]))

    def _near_pairs(self, home: int, moved: Mapping[int, Float64Array]) -> list[PlacedPair]:
        """Pictures of a part and those that would be near, at such poses (4, 4) in it; of many, some."""
        at_home = np.array(self.members[home])
        poses, pairs = np.stack([self.poses[n] for n in self.members[home]]), list[PlacedPair]()
        most_each = min(MOST_COMPARED_EACH, -(-MOST_COMPARED // len(moved)))
        for number, pose in moved.items():
            for other in at_home[near_poses(pose, poses, self._config.loop_closure)[:most_each]].tolist():
                pairs.append(self._placed.pair(other, number, inverse(self.poses[other]) @ pose))
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


def _strongest(same: BoolArray, votes: Float64Array) -> IndexArray:
    """Numbers, of those that have votes (N,), of the group with most that is the same (N, N) as one of them."""
    sums = np.where(votes > 0, same @ votes, 0.0)
    return np.flatnonzero(same[int(np.argmax(sums))] & (votes > 0))


def same_poses(first: Float64Array, second: Float64Array) -> BoolArray:
    """Which poses (N, 4, 4) are the same as others, but for drift (N,)."""
    away_m = np.linalg.norm(first[:, :3, 3] - second[:, :3, 3], axis=1)
    cosine = (np.einsum("nij,nij->n", first[:, :3, :3], second[:, :3, :3]) - 1) / 2
    same: BoolArray = (away_m <= SAME_M) & (cosine >= np.cos(np.radians(SAME_DEG)))
    return same
