"""Reassignment: a picture that lies in the wrong one of two look-alike places moves to the other, one after the other
until each lies where its neighbours have it (iterated conditional modes, Besag 1986).

A part is grown pair by pair, and what was placed early was placed by little: its true ties come later, find it placed,
and are left over.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.submaps.merge_hypotheses import MAJORITY, same_motions
from slam.backend.submaps.placement_check import PlacedPair, color_differences
from slam.backend.view_overlap import near_poses
from slam.config import SlamConfig
from slam.sparse.known_pairs import KnownPairs
from slam.sparse.measured_pair import MeasuredPair, is_sure
from slam.sparse.placement.placed_pictures import PlacedPictures

MOST_COMPARED = 16  # pictures near a place, some 2 ms each
# Times the colours that differ: of 402 pictures that ties put in two places 361 say so of the false one, none of the
# true.
CLEARLY = 2.0
SURELY = 2.0  # times what may be contradicted; walls that are seen from both sides contradict a little more
UNNOTICED = 0.25  # of the usual share of other colours, which is noise
SWEEPS = 5  # through the pictures, at most: some move to and fro


Tie = tuple[MeasuredPair, Float64Array]  # a pair, and where (4, 4) it puts the picture in question


@dataclass(frozen=True)
class PlacementFit:
    """How a picture fits at a place: the share of space it contradicts, and by how many times the usual share colours
    differ, of all readings that it shares with pictures near there (None where none shares a surface with it)."""

    contradiction: float
    color_excess: float | None

    def is_clearly_better(self, other: PlacementFit) -> bool:
        """Whether colours say so, of which more than usual must differ elsewhere."""
        if self.color_excess is None or other.color_excess is None or other.color_excess <= 1:
            return False
        return CLEARLY * (self.color_excess + UNNOTICED) <= other.color_excess + UNNOTICED


@dataclass(frozen=True)
class Reassignment:
    """Moves pictures of a part.

    Args:
        pictures: all of them, wherever they may lie.
        pairs: what is known of them.
        config: the settings.
    """

    pictures: PlacedPictures
    pairs: KnownPairs
    config: SlamConfig

    def moved(self, poses: Mapping[int, Float64Array]) -> dict[int, Float64Array]:
        """The pictures of a part that lie elsewhere, and where (4, 4).

        Args:
            poses: of all pictures of the part.
        """
        now, changed, asked = dict(poses), set[int](), set(poses)
        for _ in range(SWEEPS):
            moved = [number for number in sorted(asked) if self._move(number, now)]
            changed.update(moved)
            asked = {other for number in moved for other in self.pairs.supported.get(number, {}) if other in now}
        return {number: now[number] for number in sorted(changed)}

    def _move(self, number: int, poses: dict[int, Float64Array]) -> bool:
        here, there = self._here_and_there(number, poses)
        if not there:
            return False
        pose = there[0][1]
        if here and not self._is_better(number, pose, _weight(there) / _weight(here), poses):
            return False
        poses[number] = pose
        return True

    def undecided(self, poses: Mapping[int, Float64Array]) -> list[int]:
        """The pictures of a part that might as well lie elsewhere: ties that are sure say so, nothing contradicts them,
        and colours do not tell which is right.

        Args:
            poses: of all pictures of the part.
        """
        return [number for number in sorted(poses) if self._is_undecided(number, poses)]

    def _is_undecided(self, number: int, poses: Mapping[int, Float64Array]) -> bool:
        there = self._here_and_there(number, poses)[1]
        if not there:
            return False
        elsewhere = self._fit(number, there[0][1], poses)
        if self._is_contradicted(elsewhere, SURELY):
            return False
        return not self._fit(number, poses[number], poses).is_clearly_better(elsewhere)

    def _here_and_there(self, number: int, poses: Mapping[int, Float64Array]) -> tuple[list[Tie], list[Tie]]:
        """The ties that put a picture where it is, and the heaviest that agree on another place, if they are sure of it
        and the camera's way does not hold the picture."""
        ties = self._ties(number, poses)
        same = same_motions(np.stack([poses[number], *(pose for _, pose in ties)]), np.zeros(3))
        here = [tie for tie, is_here in zip(ties, same[0, 1:], strict=True) if is_here]
        if any(pair.is_next for pair, _ in here):
            return here, []
        groups = [[ties[n] for n in np.flatnonzero(row & ~same[0, 1:])] for row in same[1:, 1:][~same[0, 1:]]]
        groups = [group for group in groups if not self.pairs.speed.is_exceeded({number: group[0][1]}, poses)]
        there = max(groups, key=_weight, default=[])
        return here, self._registered(number, there, poses) if is_sure([pair for pair, _ in there]) else []

    def _registered(self, number: int, ties: Sequence[Tie], poses: Mapping[int, Float64Array]) -> list[Tie]:
        """Ties that agree, if as many as make sure still do once they are registered."""
        sure, left = list[Tie](), list(ties)
        while left and not is_sure([pair for pair, _ in sure]):
            tie, roughly = left.pop(0)
            pair = self.pairs.registered(tie)
            if pair is not None:
                other = pair.other(number)
                pose = poses[other] @ pair.motion(other)
                if same_motions(np.stack([roughly, pose]), np.zeros(3))[0, 1]:
                    sure.append((pair, pose))
        return [*sure, *left] if is_sure([pair for pair, _ in sure]) else []

    def _is_better(self, number: int, pose: Float64Array, times: float, poses: Mapping[int, Float64Array]) -> bool:
        """Whether a picture rather lies elsewhere, where ties say so that weigh so many times those that leave it."""
        there = self._fit(number, pose, poses)
        if self._is_contradicted(there):
            return False
        here = self._fit(number, poses[number], poses)
        is_held = here.is_clearly_better(there)  # some of what contradicts a place lies in the wrong one itself
        if self._is_contradicted(here, SURELY if is_held else 1.0) or there.is_clearly_better(here):
            return True
        return times >= MAJORITY and not is_held

    def _is_contradicted(self, fit: PlacementFit, times: float = 1.0) -> bool:
        """Whether more space is contradicted than may be, so many times."""
        return fit.contradiction > times * self.config.submaps.max_contradiction

    def _ties(self, number: int, poses: Mapping[int, Float64Array]) -> list[Tie]:
        """The pairs of a picture within the part, and where each puts it, the surest first."""
        pairs = [(pair, other) for other, pair in self.pairs.supported.get(number, {}).items() if other in poses]
        pairs.sort(key=lambda tie: (-tie[0].weight, tie[1]))
        return [(pair, poses[other] @ pair.motion(other)) for pair, other in pairs]

    def _fit(self, number: int, pose: Float64Array, poses: Mapping[int, Float64Array]) -> PlacementFit:
        others = [other for other in poses if other != number]
        near = near_poses(pose, np.stack([poses[n] for n in others]), self.config.loop_closure)[:MOST_COMPARED]
        placed = ((others[n], number, inverse(poses[others[n]]) @ pose) for n in near)
        pairs = [self.pictures.pair(*one) for one in placed]
        space = [pair.contradiction(self.config.free_space) for pair in pairs]
        return PlacementFit(float(np.mean(space or [0.0])), self._color_excess(pairs))

    def _color_excess(self, pairs: Sequence[PlacedPair]) -> float | None:
        told = color_differences(pairs, self.config)
        if not told:
            return None
        usual = self.pairs.usual_where_placed.at([pairs[n].separation for n in told])
        shares, n_readings = np.array([*told.values()]).T[:2]
        return float(n_readings @ shares / (n_readings @ usual))


def _weight(ties: Sequence[Tie]) -> float:
    return sum(pair.weight for pair, _ in ties)
