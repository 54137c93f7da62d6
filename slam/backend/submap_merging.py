"""Submaps of the map that tracking does not connect, and when enough ties them together.

One view that fits somewhere is no proof: rooms repeat. A submap is tied where several views say the same, and few say
anything else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from razer.arrays import Float64Array
from razer.geometry import inverse
from slam.backend.pose_graph import PoseEdge
from slam.se3 import angle_deg, length_m

MIN_HYPOTHESES = 3
MAJORITY = 2.0  # times as many hypotheses as for any other place
SAME_M, SAME_DEG = 0.25, 5.0  # hypotheses that differ by less say the same


@dataclass(frozen=True)
class MergeHypothesis:
    """A view of one submap found in front of a keyframe of another: the edge between keyframes that follows, and
    where it puts the submap, home_from_submap (4, 4); `strength` orders hypotheses that say the same."""

    frame: int
    edge: PoseEdge
    home_from_submap: Float64Array
    strength: float


@dataclass
class SubmapMerging:
    """What was witnessed about each pair of submaps (home < submap)."""

    _heard: dict[tuple[int, int], list[MergeHypothesis]] = field(default_factory=dict)

    def add(self, home: int, submap: int, hypothesis: MergeHypothesis) -> Sequence[MergeHypothesis]:
        """Take in a hypothesis; the agreeing ones, the strongest first, once they are enough to tie the two submaps
        together, else none."""
        heard = self._heard.setdefault((home, submap), [])
        heard.append(hypothesis)
        agreeing = [other for other in heard if _agree(hypothesis, other)]
        against = [other for other in heard if not _agree(hypothesis, other)]
        rival = max((_voices([o for o in against if _agree(w, o)]) for w in against), default=0)
        if _voices(agreeing) < max(MIN_HYPOTHESES, MAJORITY * rival):
            return ()
        return sorted(agreeing, key=lambda other: -other.strength)

    def forget(self, submap: int) -> None:
        """The submap is no more: it became part of another."""
        self._heard = {pair: heard for pair, heard in self._heard.items() if submap not in pair}


def _agree(a: MergeHypothesis, b: MergeHypothesis) -> bool:
    off = inverse(a.home_from_submap) @ b.home_from_submap
    return length_m(off) <= SAME_M and angle_deg(off) <= SAME_DEG


def _voices(hypotheses: Sequence[MergeHypothesis]) -> int:
    """How many views they are: what one view sees in several keyframes, it sees once."""
    return len({hypothesis.frame for hypothesis in hypotheses})
