"""Placement check: whether views, once they are placed among others, contradict what these saw.

A look-alike is like the view it was taken for, and not like the views around that one: its things stand where these
looked through, or have other colours.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from razer.arrays import Float64Array, IndexArray, Int64Array
from razer.geometry import inverse
from slam.backend.pose_graph import PoseGraph
from slam.backend.submaps.chain_ties import way_to_ties
from slam.backend.view_checks.color_check import ColorDifference, color_difference
from slam.backend.view_checks.free_space_check import contradiction
from slam.backend.view_checks.usual_colors import LEAST_USUAL, NOISE, UsualColors, place_weights, reading_weights
from slam.backend.view_overlap import near_poses, separation
from slam.config import FreeSpaceSettings, SlamConfig
from slam.frontend.keyframes import Keyframes, View

PROBES = 40  # edges by which it is told how much colours usually differ, as many of each chain, ...
ENOUGH_PROBES = 6  # ... and at least so many, to tell that its colours differ by more than those of others
UNTOLD = 0.75  # quantile of what all of them tell, by which much may differ in a chain that tells less
MOST_PAIRS = 100  # of views that are compared, some 2 ms each
FEWEST_TOLD = 1500  # readings that they must share, a third of a view, before colours say anything
UNNOTICED = 0.03  # mean share of other colours that tells nothing, however alike colours usually are
# Where things alike are of other colours in part, little of any view is, but more than usual of most views: of so many
# pairs this share is too much. Of true ones it is a quarter at most, of look-alikes two fifths and more.
MANY_TOLD, TOO_MANY = 10, 1 / 3
# And what differs by less than any of that, but again and again, is another place: so many pairs say so much on the
# whole, see `place_weights`. True ones of rooms have -1.2 to -1.5 (eleven had -0.8 once), twin rooms that differ least
# -0.7 and more. Only where light stayed: it changes by 1.4 to 2.6 times the usual between twins, by 3 and more in the
# evening.
MANY_AGAIN, AGAIN_AND_AGAIN, SAME_LIGHT = 15, -0.95, 2.8


# Other light changes how bright all of a place is, and hardly its hues; other things change some of it, and those too.
# Light is another if even the quarter of the readings that differs least does so by this many times what is usual, and
# hues do by no more than so many times. Shadows, and what glows, are then so many times as large a share of colours as
# that quarter differs by. Rooms by day and in the evening have 2.4 to 13 times, 1.4 to 4.9 times, and 0.3 to 3.3; twin
# rooms in one light 1.4 to 4.1 times the usual, and where that is 3.2 or more, 7 and more.
OTHER_LIGHT, SAME_HUES, SHADOWS = 4.0, 3.3, 4.0


class UsualDifferences(NamedTuple):
    """What is usual in this recording, between views of one place in one light; see `ColorDifference`.

    Attributes:
        shares: (N,) of other colours, between views as far apart as those of N pairs.
        light_change: inf, it is not known.
        hue_change: of all pairs.
        bare_shares: (N,) like shares, but for what is noise however alike colours usually are; None, it is not known.
    """

    shares: Float64Array
    light_change: float = np.inf
    hue_change: float = 0.0
    bare_shares: Float64Array | None = None


class Scrutiny(NamedTuple):
    """How closely pairs of views are looked at.

    Attributes:
        fewest_told: readings that pairs must share, all together, for colours to count.
        many_told: pairs that must share some, for a little that differs in many of them to count; None, it does not.
        share, many: what the bounds on other colours on the whole, and on the pairs that have too many, are multiplied
            by; drift alone brings space half way to its bound.
        hues: what the bound on hues is multiplied by, that other light may change.
        again: whether a little that differs again and again is another place.
    """

    fewest_told: int = 1
    many_told: int | None = None
    share: float = 1.0
    many: float = 1.0
    hues: float = 1.0
    again: bool = True


LENIENT = Scrutiny()  # as few pictures without order allow, whose pairs all share little
USUAL = Scrutiny(FEWEST_TOLD, MANY_TOLD)
# True pairs of a kitchen, across a change of exposure, have 1.6 times the usual on the whole, few of them too many.
STRICT = Scrutiny(FEWEST_TOLD, MANY_TOLD, share=2 / 3, many=1 / 2)
# More of what was just believed is seen with each frame, and colours vary: no little more of them parts it again.
PLACED = Scrutiny(FEWEST_TOLD, MANY_TOLD, hues=1.2, again=False)


@dataclass(frozen=True, eq=False)
class PlacedPair:
    """Two views as they would lie: first_from_second (4, 4), which may be off by `drift_m` metres."""

    first: View
    second: View
    first_from_second: Float64Array
    drift_m: float = 0.0

    @classmethod
    def of(cls, keyframes: Keyframes, a: int, b: int, a_from_b: Float64Array, drift_m: float = 0.0) -> PlacedPair:
        """The views of two keyframes."""
        return cls(keyframes[a].view, keyframes[b].view, a_from_b, drift_m)

    def contradiction(self, settings: FreeSpaceSettings) -> float:
        """Share of readings that stand where the other view saw through, by more than drift explains."""
        return contradiction(self.first, self.second, self.first_from_second, settings, self.drift_m)

    def color_difference(self, settings: FreeSpaceSettings) -> ColorDifference | None:
        """Share of readings of the same surface whose colours differ; None where the two share too few."""
        return color_difference(self.first, self.second, self.first_from_second, settings)

    @property
    def separation(self) -> float:
        """How far apart the two were taken."""
        return separation(self.first, self.second, self.first_from_second)


@dataclass
class PlacementCheck:
    """Compares keyframes with those round about that they did not come with."""

    keyframes: Keyframes
    graph: PoseGraph
    config: SlamConfig

    def contradicts(
        self,
        placed: Sequence[int],
        standing: IndexArray,
        standing_from_placed: Float64Array,
        ties: Int64Array,
        strictly: bool = False,
    ) -> bool:
        """Whether keyframes are not where they would be; not, where nobody sees what they see. What lies far from the
        ties may have drifted, and contradicts the less.

        Args:
            placed: numbers of those in question.
            standing: numbers (N,) of the others.
            standing_from_placed: (4, 4) by what those in question are moved; the identity if they are placed.
            ties: (T, 2) keyframes, one in question and one of the others, which say that they lie there.
            strictly: whether their colours must fit better than others must.
        """
        pairs = self._pairs(placed, standing, standing_from_placed, self._drift_m(standing, ties))
        is_placed = np.array_equal(standing_from_placed, np.eye(4))
        scrutiny = STRICT if strictly else PLACED if is_placed else USUAL
        return contradict(pairs, self._usual_differences, self.config, scrutiny)

    def _drift_m(self, standing: IndexArray, ties: Int64Array) -> Float64Array:
        """By how much (K,) each keyframe may have drifted from where the ties have it; not at all without any."""
        if not len(ties):
            return np.zeros(len(self.keyframes))
        ends = self.graph.edge_table()[0]
        is_within = np.isin(ends, standing).sum(axis=1) != 1
        way_m = way_to_ties(ties, self.keyframes.poses()[:, :3, 3], ends[is_within])
        return self.config.loop_closure.drift_m_per_m * np.where(np.isfinite(way_m), way_m, 0.0)

    def _pairs(
        self, placed: Sequence[int], standing: IndexArray, standing_from_placed: Float64Array, drift_m: Float64Array
    ) -> list[PlacedPair]:
        """Views, and the motion between them; of many, some of all."""
        poses, pairs = self.keyframes.poses()[standing], list[PlacedPair]()
        for number in placed:
            moved = standing_from_placed @ self.keyframes[number].world_from_camera
            for other in standing[near_poses(moved, poses, self.config.loop_closure)].tolist():
                motion = inverse(self.keyframes[other].world_from_camera) @ moved
                drifted_m = float(drift_m[other] + drift_m[number])
                pairs.append(PlacedPair.of(self.keyframes, other, number, motion, drifted_m))
        return pairs[:: -(-len(pairs) // MOST_PAIRS) or 1]

    def _usual_differences(self, pairs: Sequence[PlacedPair]) -> UsualDifferences:
        """What differs between keyframes of one odometry chain as far apart as those of pairs: exposure, light, the
        camera. Shares are those of the chain of the two where they are more, since a camera that looks at windows and
        metal has several times what it has elsewhere. A chain that has told too little of itself may be one that has
        more than most."""
        separations, (shares, _, *changes), chains = self._probes()
        chain_of = {keyframe.view.index: keyframe.chain for keyframe in self.keyframes.all}
        ends = [(chain_of[pair.first.index], chain_of[pair.second.index]) for pair in pairs]
        apart = [pair.separation for pair in pairs]

        def usually(least: float) -> Float64Array:
            usual = UsualColors(separations.tolist(), shares.tolist(), least)
            return usual.at(apart) * _times_of_chains(shares / usual.at(separations.tolist()), chains, ends)

        if len(shares) < ENOUGH_PROBES:
            return UsualDifferences(usually(LEAST_USUAL))
        light_change, hue_change = (float(np.median(each)) for each in changes)
        return UsualDifferences(usually(LEAST_USUAL), light_change, hue_change, usually(NOISE))

    def _probes(self) -> tuple[Float64Array, Float64Array, Int64Array]:
        """How far pairs of keyframes of one chain were taken apart (P,), how their colours differ (4, P), and which
        chain it is."""
        keyframes, edges, all_chains = self.keyframes, self.graph.edges, np.unique(self.keyframes.chains()).tolist()
        known, chains, most = list[PlacedPair](), list[int](), max(PROBES // len(all_chains), ENOUGH_PROBES)
        for chain in all_chains:
            within = [edge for edge in edges if keyframes[edge.a].chain == keyframes[edge.b].chain == chain]
            for edge in within[:: -(-len(within) // most) or 1]:
                known.append(PlacedPair.of(keyframes, edge.a, edge.b, edge.a_from_b))
                chains.append(chain)
        differences = color_differences(known, self.config)
        separations = np.array([known[n].separation for n in differences])
        told = np.array([*differences.values()], np.float64).reshape(-1, len(ColorDifference._fields))
        return separations, told.T, np.array([chains[n] for n in differences], np.int64)


def _times_of_chains(times: Float64Array, chains: Int64Array, ends: Sequence[tuple[int, int]]) -> Float64Array:
    """Times the usual (N,) that the colours of pairs differ by their two chains, of which (P,) probes tell (P,)."""
    of_chain = {
        chain: max(1.0, float(np.median(times[chains == chain])))
        for chain in np.unique(chains).tolist()
        if (chains == chain).sum() >= ENOUGH_PROBES
    }
    untold = max(1.0, float(np.quantile(times, UNTOLD))) if len(times) else 1.0
    return np.array([max(of_chain.get(a, untold), of_chain.get(b, untold)) for a, b in ends])


def contradict(
    pairs: Sequence[PlacedPair],
    usual_differences: Callable[[Sequence[PlacedPair]], UsualDifferences],
    config: SlamConfig,
    scrutiny: Scrutiny = LENIENT,
) -> bool:
    """Whether pairs of views, all taken together, contradict each other; not, where there are none. Where drift may
    have shifted colours, space alone does.

    Args:
        pairs: views as they would lie.
        usual_differences: what differs, of one place in this recording, between views placed to each other like each
            of N pairs.
        config: the settings.
        scrutiny: how closely they are looked at.
    """
    if not pairs:
        return False
    space = np.mean([pair.contradiction(config.free_space) for pair in pairs])
    if space > config.submaps.max_contradiction:
        return True
    in_place = [pair for pair in pairs if pair.drift_m <= config.loop_closure.drift_m]
    colors = color_differences(in_place, config)
    if sum(difference.n_readings for difference in colors.values()) < scrutiny.fewest_told:
        return False
    usual = usual_differences([in_place[n] for n in colors])
    if scrutiny.again and _differ_again_and_again([*colors.values()], usual):
        return True
    most_usual = np.maximum(
        config.submaps.max_color_excess * usual.shares, _of_other_light([*colors.values()], usual, scrutiny)
    )
    return _are_other([*colors.values()], most_usual, scrutiny)


def _of_other_light(differences: Sequence[ColorDifference], usual: UsualDifferences, scrutiny: Scrutiny) -> float:
    """What share of colours other light may change between pairs; none where it is the same, or more than light is."""
    _, n_readings, *changes = np.array(differences).T
    light_change, hue_change = (float(np.average(each, weights=n_readings)) for each in changes)
    most_hues = scrutiny.hues * SAME_HUES * usual.hue_change
    is_light = light_change >= OTHER_LIGHT * usual.light_change and hue_change <= most_hues
    return SHADOWS * light_change if is_light else 0.0


def _differ_again_and_again(differences: Sequence[ColorDifference], usual: UsualDifferences) -> bool:
    """Whether most of many pairs have more other colours than usual, where that is too little for other rules."""
    bare = usual.bare_shares
    if bare is None or len(differences) < MANY_AGAIN or bare.mean() >= LEAST_USUAL:
        return False
    shares, n_readings, light_changes, _ = np.array(differences).T
    if np.average(light_changes, weights=n_readings) > SAME_LIGHT * usual.light_change:
        return False
    told = np.average(place_weights(shares, bare), weights=reading_weights(n_readings))
    return bool(told > AGAIN_AND_AGAIN)


def _are_other(differences: Sequence[ColorDifference], most_usual: Float64Array, scrutiny: Scrutiny) -> bool:
    """Whether more of the colours of pairs differ than is usual at most (N,): on the whole, or of too many pairs. Pairs
    count by the readings they share: rims, which are all that distant views share, lie a pixel off."""
    shares, n_readings = np.array(differences).T[:2]
    share, most = (np.average(each, weights=n_readings) for each in (shares, most_usual))
    if share > max(most, UNNOTICED) * scrutiny.share:
        return True
    too_many = np.average(shares > most_usual, weights=n_readings) > TOO_MANY * scrutiny.many
    return scrutiny.many_told is not None and len(shares) >= scrutiny.many_told and bool(too_many)


def color_differences(pairs: Sequence[PlacedPair], config: SlamConfig) -> dict[int, ColorDifference]:
    """How colours differ, by number, of those pairs that share a surface."""
    differences = ((n, pair.color_difference(config.free_space)) for n, pair in enumerate(pairs))
    return {n: difference for n, difference in differences if difference is not None}
