"""Submap merging: when hypotheses about where an unanchored submap lies are enough to merge it with another.

One view that fits somewhere is no proof: rooms repeat. Submaps are merged where several views agree, and few
contradict them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.config import SubmapSettings
from slam.pose_edge import PoseEdge
from slam.se3 import angle_deg, length_m

MAJORITY = 2.0  # times as many hypotheses as for any other place; a place beside its look-alike has that soon
SAME_M, SAME_DEG = 0.25, 5.0  # hypotheses that differ by less agree: the drift within a submap


@dataclass(frozen=True)
class MergeHypothesis:
    """A view of one submap registered to a keyframe of another: the edge between keyframes that follows, and where it
    puts the submap, home_from_submap (4, 4); `strength` orders hypotheses that agree."""

    frame: int
    edge: PoseEdge
    home_from_submap: Float64Array
    strength: float


@dataclass
class SubmapMerging:
    """The hypotheses about each pair of submaps (home < submap)."""

    settings: SubmapSettings
    _hypotheses: dict[tuple[int, int], list[MergeHypothesis]] = field(default_factory=dict)

    def add(self, home: int, submap: int, hypothesis: MergeHypothesis) -> Sequence[MergeHypothesis]:
        """Take in a hypothesis; the agreeing ones, the strongest first, once they are enough to merge the two submaps,
        else none."""
        hypotheses = self._hypotheses.setdefault((home, submap), [])
        hypotheses.append(hypothesis)
        agreeing = [other for other in hypotheses if _agree(hypothesis, other)]
        against = [other for other in hypotheses if not _agree(hypothesis, other)]
        rival = max((_n_views([other for other in against if _agree(one, other)]) for one in against), default=0)
        if _n_views(agreeing) < max(self.settings.min_hypotheses, MAJORITY * rival):
            return ()
        return sorted(agreeing, key=lambda other: -other.strength)

    def expected(self, submap: int) -> list[tuple[int, Float64Array]]:
        """Other submaps that hypotheses connect one with, and other_from_submap (4, 4) as most views have it."""
        found = []
        for (home, other), hypotheses in self._hypotheses.items():
            if submap in (home, other):
                best = max(hypotheses, key=lambda one: _n_views([two for two in hypotheses if _agree(one, two)]))
                home_from_other = best.home_from_submap
                found.append((home, home_from_other) if submap == other else (other, inverse(home_from_other)))
        return found

    def forget(self, submap: int) -> None:
        """The submap is no more: it became part of another."""
        self._hypotheses = {pair: kept for pair, kept in self._hypotheses.items() if submap not in pair}


def _agree(a: MergeHypothesis, b: MergeHypothesis) -> bool:
    offset = inverse(a.home_from_submap) @ b.home_from_submap
    return length_m(offset) <= SAME_M and angle_deg(offset) <= SAME_DEG


def _n_views(hypotheses: Sequence[MergeHypothesis]) -> int:
    """How many views they are of: one view that fits several keyframes counts once."""
    return len({hypothesis.frame for hypothesis in hypotheses})
