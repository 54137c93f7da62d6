"""Merge hypotheses: where views say that a submap lies in front of another, and when they are enough to believe it.

One view that fits somewhere is no proof: rooms repeat. Submaps are merged where several views agree, and few
contradict them.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

import numpy as np

from razer.arrays import BoolArray, Float64Array, Int64Array
from razer.geometry import inverse
from slam.frontend.keyframes import Keyframe, Keyframes
from slam.pose_edge import PoseEdge
from slam.submap_settings import SubmapSettings

MAJORITY = 2.0  # times as many hypotheses as for any other place; a place beside its look-alike has that soon
SAME_M, SAME_DEG = 0.25, 5.0  # hypotheses that differ by less agree: the drift within a submap


@dataclass(frozen=True, eq=False)
class MergeHypothesis:
    """A view of one odometry chain registered to a keyframe of another: the view's frame, and the edge between
    keyframes that follows; `strength` orders hypotheses that agree."""

    frame: int
    edge: PoseEdge
    strength: float


@dataclass
class MergeHypotheses:
    """All that came up and was not refuted."""

    keyframes: Keyframes
    settings: SubmapSettings
    _all: list[MergeHypothesis] = field(default_factory=list)
    _refused: list[MergeHypothesis] = field(default_factory=list)  # one of each time that a place was looked into

    def add(self, hypothesis: MergeHypothesis) -> None:
        """Take in a further one."""
        self._all.append(hypothesis)

    def refuse(self, hypotheses: Sequence[MergeHypothesis]) -> None:
        """Refute those that agree, since views contradict them: twice as many must now say so before the place is
        looked into again, as a look-alike comes up with every view."""
        self._refused.append(hypotheses[0])
        self.refute(hypotheses)

    def was_refused(self, hypothesis: MergeHypothesis) -> bool:
        """Whether the place that one leads to was refused before."""
        return bool(self._times_refused([hypothesis])[0])

    def refute(self, hypotheses: Sequence[MergeHypothesis]) -> None:
        """Forget some that others contradict: as many must come up anew before the same is believed."""
        refuted = set(map(id, hypotheses))
        self._all = [one for one in self._all if id(one) not in refuted]

    def tying(self, numbers: Collection[int]) -> list[MergeHypothesis]:
        """Those between some keyframes and others."""
        return [one for one in self._all if (one.edge.a in numbers) != (one.edge.b in numbers)]

    def ends(self, hypothesis: MergeHypothesis) -> tuple[Keyframe, Keyframe]:
        """The two keyframes it ties, that of the earlier submap, or else chain, first."""
        a, b = self.keyframes[hypothesis.edge.a], self.keyframes[hypothesis.edge.b]
        return (a, b) if (a.submap, a.chain) <= (b.submap, b.chain) else (b, a)

    def shift(self, hypothesis: MergeHypothesis) -> Float64Array:
        """By what the later of the two must be moved (4, 4), in the world of the earlier as its keyframes have it."""
        edge = hypothesis.edge
        a, b = self.keyframes[edge.a], self.keyframes[edge.b]
        shift = a.world_from_camera @ edge.a_from_b @ inverse(b.world_from_camera)
        return shift if self.ends(hypothesis)[0] is a else inverse(shift)

    def enough(self, hypothesis: MergeHypothesis) -> Sequence[MergeHypothesis]:
        """Those of the same two parties that agree with one, the strongest first, once they are enough to believe it;
        else none. Within a submap, what says that all is in place already is not counted."""
        parties = self._parties(hypothesis)
        others = [other for other in self._all if self._parties(other) == parties]
        if parties[0] == parties[1]:
            others = self._out_of_place(others)
        if hypothesis not in others:
            return ()
        agree, n_refused = same_motions(*self._shifts(others)), self._times_refused(others)
        agreeing = agree[others.index(hypothesis)]
        is_rival = ~agreeing & (n_refused == 0)
        rival = max((_n_views(others, row & is_rival) for row in agree[is_rival]), default=0)
        needed = self.settings.min_hypotheses * 2 ** n_refused[others.index(hypothesis)]
        if _n_views(others, agreeing) < max(needed, MAJORITY * rival):
            return ()
        found = [others[n] for n in np.flatnonzero(agreeing)]
        return sorted(found, key=lambda other: -other.strength)

    def _times_refused(self, hypotheses: Sequence[MergeHypothesis]) -> Int64Array:
        """How often the place (N,) was refused that hypotheses of the same two parties lead to."""
        parties = self._parties(hypotheses[0])
        refused = [one for one in self._refused if self._parties(one) == parties]
        same = same_motions(*self._shifts([*hypotheses, *refused]))
        return same[: len(hypotheses), len(hypotheses) :].sum(axis=1)

    def _out_of_place(self, hypotheses: Sequence[MergeHypothesis]) -> list[MergeHypothesis]:
        """Those by which the later party would be moved."""
        shifts, at = self._shifts(hypotheses)
        in_place = same_motions(np.concatenate([shifts, np.eye(4)[None]]), at)[-1, :-1]
        return [one for one, is_in_place in zip(hypotheses, in_place, strict=True) if not is_in_place]

    def expected(self, submap: int) -> list[tuple[int, Float64Array]]:
        """Other submaps that hypotheses connect one with, and other_from_submap (4, 4) as most views have it; also as
        most have it of those that lead to no place that was refused, as a look-alike has more views."""
        by_pair: dict[tuple[int, int], list[MergeHypothesis]] = {}
        for hypothesis in self._all:
            first, second = (keyframe.submap for keyframe in self.ends(hypothesis))
            if first != second and submap in (first, second):
                by_pair.setdefault((first, second), []).append(hypothesis)
        found = []
        for (first, second), hypotheses in by_pair.items():
            agree = same_motions(*self._shifts(hypotheses))
            n_views = np.array([_n_views(hypotheses, row) for row in agree])
            n_unrefused = np.where(self._times_refused(hypotheses) == 0, n_views, 0)
            places = {int(np.argmax(counted)) for counted in (n_views, n_unrefused) if counted.any()}
            for shift in (self.shift(hypotheses[n]) for n in sorted(places)):
                found.append((first, shift) if submap == second else (second, inverse(shift)))
        return found

    def _parties(self, hypothesis: MergeHypothesis) -> tuple[int, ...]:
        """Two submaps, or two chains within one."""
        first, second = self.ends(hypothesis)
        if first.submap != second.submap:
            return first.submap, second.submap
        return first.submap, second.submap, first.chain, second.chain

    def _shifts(self, hypotheses: Sequence[MergeHypothesis]) -> tuple[Float64Array, Float64Array]:
        """By what they move the later party (N, 4, 4), and where that sees it (3,)."""
        shifts = np.stack([self.shift(one) for one in hypotheses]) if hypotheses else np.zeros((0, 4, 4))
        places = [self.ends(one)[1].world_from_camera[:3, 3] for one in hypotheses]
        return shifts, np.mean(places, axis=0) if places else np.zeros(3)


def same_motions(
    motions: Float64Array, at: Float64Array, same_m: float = SAME_M, same_deg: float = SAME_DEG
) -> BoolArray:
    """Which of the motions (N, 4, 4) bring what is at a place (3,) to one place (N, N), but for drift."""
    moved = motions[:, :3, :3] @ at + motions[:, :3, 3]
    away_m = np.linalg.norm(moved[:, None] - moved, axis=2)
    cosine = (np.einsum("nij,mij->nm", motions[:, :3, :3], motions[:, :3, :3]) - 1) / 2
    same: BoolArray = (away_m <= same_m) & (cosine >= np.cos(np.radians(same_deg)))
    return same


def _n_views(hypotheses: Sequence[MergeHypothesis], chosen: BoolArray) -> int:
    """How many views those chosen (N,) are of: one view that fits several keyframes counts once."""
    return len({hypotheses[n].frame for n in np.flatnonzero(chosen).tolist()})
