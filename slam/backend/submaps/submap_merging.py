"""Submap merging: submaps become part of others, and odometry chains are moved, or parted again, where what was
believed proves wrong."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np

from razer.arrays import Float64Array, IndexArray, Int64Array
from razer.geometry import inverse
from slam.backend.pose_graph import PoseGraph
from slam.backend.submaps.chain_ties import hanging_on
from slam.backend.submaps.merge_hypotheses import MergeHypotheses, MergeHypothesis
from slam.backend.submaps.placement_check import PlacementCheck
from slam.frontend.keyframes import Keyframe, Keyframes
from slam.pose_edge import PoseEdge

FEW_PLACED = 3  # keyframes; the colours of fewer must fit twice as well
REVIEWED = 8  # newest keyframes of a chain that are held against what others saw there, ...
REVIEW_EACH = 4  # ... each time that it grew by so many, as that takes some 0.2 s


class Outcome(Enum):
    """Of a hypothesis: it waits for others, proved wrong with those that agree, or moved keyframes."""

    WAITS = auto()
    REFUTED = auto()
    MOVED = auto()


@dataclass
class SubmapMerging:
    """Decides which keyframes are of one submap, and moves them."""

    keyframes: Keyframes
    graph: PoseGraph
    hypotheses: MergeHypotheses
    placement: PlacementCheck

    def add(self, edge: PoseEdge, frame: int, strength: float) -> Outcome:
        """Take in that a view of one chain fits into another, or elsewhere in its own.

        Args:
            edge: between keyframes, that follows from it.
            frame: of the view.
            strength: how well it fits.
        """
        hypothesis = MergeHypothesis(frame, edge, strength)
        self.hypotheses.add(hypothesis)
        agreeing = self.hypotheses.enough(hypothesis)
        if not agreeing:
            return Outcome.WAITS
        home, later = self.hypotheses.ends(hypothesis)
        if home.submap != later.submap:
            is_done = self._merge(home, later, agreeing)
        elif home.chain != later.chain:
            is_done = self._move(home, later, agreeing)
        else:
            is_done = self._may_close(home, agreeing)
        if not is_done:
            self.hypotheses.refuse(agreeing)
            return Outcome.REFUTED
        for one in agreeing:
            self.graph.add_edge(one.edge)
        return Outcome.MOVED

    def _merge(self, home: Keyframe, later: Keyframe, agreeing: Sequence[MergeHypothesis]) -> bool:
        """Make a submap part of another, unless its views contradict that."""
        numbers, shift = self.keyframes.of_submap(later.submap), self.hypotheses.shift(agreeing[0])
        others, strictly = self.keyframes.of_submap(home.submap), self._is_doubtful(agreeing[0], len(numbers))
        if self.placement.contradicts(numbers.tolist(), others, shift, _ties(agreeing), strictly):
            return False
        self._shift(numbers, shift)
        self._assign(numbers, home.submap)
        return True

    def _move(self, home: Keyframe, later: Keyframe, agreeing: Sequence[MergeHypothesis]) -> bool:
        """Move a chain that is where views contradict it to where others say it lies."""
        shift = self.hypotheses.shift(agreeing[0])
        for chain, moved in ((later.chain, shift), (home.chain, inverse(shift))):
            numbers, others = self._parts(chain)
            seen = [n for one in agreeing for n in (one.edge.a, one.edge.b) if n in numbers]
            if 0 in numbers or not self.placement.contradicts(seen, others, np.eye(4), self._ties(numbers)):
                continue
            strictly = self._is_doubtful(agreeing[0], len(numbers))
            if not self.placement.contradicts(numbers.tolist(), others, moved, _ties(agreeing), strictly):
                self._part(numbers)
                self._shift(numbers, moved)
                return True
        return False

    def _may_close(self, home: Keyframe, agreeing: Sequence[MergeHypothesis]) -> bool:
        """Whether a loop of one chain may be closed: views that came back do not contradict what is there."""
        there, back = np.array([sorted((one.edge.a, one.edge.b)) for one in agreeing]).T
        numbers, shift = self.keyframes.of_submap(home.submap), self.hypotheses.shift(agreeing[0])
        others = numbers[numbers < (there.max() + back.min()) / 2]  # what comes after drifted with them
        return not self.placement.contradicts(np.unique(back).tolist(), others, shift, _ties(agreeing), strictly=True)

    def _is_doubtful(self, hypothesis: MergeHypothesis, n_placed: int) -> bool:
        """Whether so many keyframes must fit well where one says: a look-alike comes up again until chance has it pass,
        and of few keyframes as these see one side of it only."""
        return n_placed < FEW_PLACED or self.hypotheses.was_refused(hypothesis)

    def review(self, chain: int, free_submap: int) -> bool:
        """Let a chain that grew be a submap of its own, with an unused number, where its newest views contradict what
        others saw; whether that was so."""
        numbers, others = self._parts(chain)
        grown = numbers[self.keyframes.chains()[numbers] == chain]
        if 0 in numbers or not len(others) or len(grown) % REVIEW_EACH:
            return False
        newest = grown[-REVIEWED:].tolist()
        if not self.placement.contradicts(newest, others, np.eye(4), self._ties(numbers)):
            return False
        self._part(numbers)
        self._assign(numbers, free_submap)
        return True

    def _parts(self, chain: int) -> tuple[IndexArray, IndexArray]:
        """The keyframes that hang on a chain, and the others of its submap."""
        numbers = hanging_on(chain, self.keyframes.chains(), self.graph.edge_table()[0])
        return numbers, np.setdiff1d(self.keyframes.of_submap(self.keyframes[int(numbers[0])].submap), numbers)

    def _ties(self, numbers: IndexArray) -> Int64Array:
        """The ends (T, 2) of the edges between some keyframes and the others."""
        ends = self.graph.edge_table()[0]
        return ends[np.isin(ends, numbers).sum(axis=1) == 1]

    def _shift(self, numbers: Iterable[int], shift: Float64Array) -> None:
        for number in numbers:
            self.keyframes[number].world_from_camera = shift @ self.keyframes[number].world_from_camera
        self.graph.shift({k.number: k.world_from_camera for k in self.keyframes.all})

    def _assign(self, numbers: Iterable[int], submap: int) -> None:
        for number in numbers:
            self.keyframes[number].submap = submap

    def _part(self, numbers: IndexArray) -> None:
        """Let go of all that ties some keyframes to others, and of what was believed of them: it proved wrong."""
        inside = set(numbers.tolist())
        self.hypotheses.refute(self.hypotheses.tying(inside))
        self.graph.replace([edge for edge in self.graph.edges if (edge.a in inside) == (edge.b in inside)])


def _ties(hypotheses: Sequence[MergeHypothesis]) -> Int64Array:
    """The keyframes (T, 2) that some hypotheses tie."""
    return np.array([(one.edge.a, one.edge.b) for one in hypotheses], np.int64)
