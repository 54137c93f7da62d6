"""Parts: what pictures fall into in the end. What is grown pair by pair lies in the wrong place here and there, or by
too little to say where."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.cluster.hierarchy import DisjointSet

from slam.sparse.measured_pair import MeasuredPair
from slam.sparse.pair_graph import components
from slam.sparse.placement.color_cut import color_cut
from slam.sparse.placement.grown_parts import GrownParts, same_poses
from slam.sparse.placement.reassignment import Reassignment

# Pictures that one holds without saying where it lies: so many at the most, and so small a share of what is left.
MOST_HANGING, HANGING_SHARE = 3, 0.25
MOST_ALIKE = 5  # pairs of places that look alike, one after the other
ROUNDS = 5  # of moving pictures and joining what that leaves, at most: some move to and fro


class Parts(GrownParts):
    """The parts that pictures fall into in the end."""

    def settle(self) -> None:
        """Grow to what pictures fall into in the end."""
        self._arrange()
        for _ in range(MOST_ALIKE):
            if not self.part_look_alikes():
                break
            self._arrange()
        while self.leave_undecided():  # what lay beside what was left out is held by less
            pass
        self.secure()

    def _arrange(self) -> None:
        """Grow, and let pictures move to where they rather belong."""
        self.grow()
        for _ in range(ROUNDS):
            if not self.reassign():
                break
            self.grow()

    def reassign(self) -> bool:
        """Move pictures that lie in the wrong one of two look-alike places to the other, part what that leaves without
        a tie, and say whether any was moved."""
        return sum(self._reassign(part) for part in sorted(self.members)) > 0

    def part_look_alikes(self) -> bool:
        """Part pictures of two places that look alike and lie on each other, forget what tied them, and say whether
        there were any."""
        n_before = len(self.members)
        for part in sorted(self.members):
            alike = color_cut(self._placed, self._poses_of(part), self._config)
            if alike:
                self._pairs.forget(pair for pair in self.agreeing(part) if len(alike.intersection(pair.ends)) == 1)
                self._split(part)
        return len(self.members) > n_before

    def leave_undecided(self) -> bool:
        """Part what might as well lie in another place from the rest, and say whether there was anything; but not what
        holds the rest together, which says from two sides where it lies; a few that hang by it go with it."""
        n_before = len(self.members)
        for part in sorted(self.members):
            alone = list[int]()
            for number in self._reassignment.undecided(self._poses_of(part)):
                if self._holds_few(part, [*alone, number]):
                    alone.append(number)
            if alone:
                self._split(part, alone)
        return len(self.members) > n_before

    def _holds_few(self, part: int, alone: Sequence[int]) -> bool:
        """Whether hardly anything of a part hangs by some of its pictures."""
        others = [numbers for numbers in self._tied_together(part, alone) if numbers[0] not in alone]
        *hanging, rest = sorted(map(len, others)) or [0]
        return max(hanging, default=0) <= min(MOST_HANGING, HANGING_SHARE * rest)

    def secure(self) -> None:
        """Register what holds each part together, and part what no registration ties to the rest."""
        for part in sorted(self.members):
            tied = DisjointSet(self.members[part])
            for pair in sorted(self.agreeing(part), key=lambda pair: (not pair.is_registered, -pair.weight)):
                if not tied.connected(*pair.ends) and self._bears_out(self._pairs.registered(pair)):
                    tied.merge(*pair.ends)
            if tied.n_subsets > 1:
                del self.members[part]
                for numbers in tied.subsets():
                    self._set_apart(sorted(numbers))

    def _bears_out(self, pair: MeasuredPair | None) -> bool:
        """Whether a pair puts its pictures where they are."""
        if pair is None:
            return False
        a, b = pair.ends
        return bool(same_poses((self.poses[a] @ pair.edge.a_from_b)[None], self.poses[b][None])[0])

    @property
    def _reassignment(self) -> Reassignment:
        return Reassignment(self._placed, self._pairs, self._config)

    def _reassign(self, part: int) -> bool:
        moved = self._reassignment.moved(self._poses_of(part))
        if moved:
            self.poses.update(moved)
            self._split(part)
        return bool(moved)

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
