"""Placement check: whether views, once they are placed among others, contradict what these saw.

A look-alike is like the view it was taken for, and not like the views around that one: its things stand where these
looked through, or have other colours.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from razer.arrays import Float64Array, IndexArray
from razer.geometry import inverse
from slam.backend.pose_graph import PoseGraph
from slam.backend.view_checks.color_check import other_colors
from slam.backend.view_checks.free_space_check import contradiction
from slam.backend.view_checks.usual_colors import UsualColors
from slam.backend.view_overlap import near_poses, separation
from slam.config import SlamConfig
from slam.frontend.keyframes import Keyframes, View

PROBES = 40  # edges by which it is told how much colours usually differ
MOST_PAIRS = 100  # of views that are compared, some 2 ms each
UNNOTICED = 0.03  # share of other colours that tells nothing, however alike colours usually are

PlacedPair = tuple[View, View, Float64Array]  # two views, and first_from_second (4, 4)


@dataclass
class PlacementCheck:
    """Compares keyframes with those round about that they did not come with."""

    keyframes: Keyframes
    graph: PoseGraph
    config: SlamConfig

    def contradicts(self, placed: Iterable[int], standing: IndexArray, standing_from_placed: Float64Array) -> bool:
        """Whether keyframes are not where they would be; not, where nobody sees what they see.

        Args:
            placed: numbers of those in question.
            standing: numbers (N,) of the others.
            standing_from_placed: (4, 4) by what those in question are moved.
        """
        pairs = self._pairs(placed, standing, standing_from_placed)
        return contradict(pairs, self._usual_other_colors, self.config)

    def _pairs(
        self, placed: Iterable[int], standing: IndexArray, standing_from_placed: Float64Array
    ) -> list[PlacedPair]:
        """Views, and the motion between them; of many, some of all."""
        poses, pairs = self.keyframes.poses()[standing], list[PlacedPair]()
        for number in placed:
            moved = standing_from_placed @ self.keyframes[number].world_from_camera
            for other in standing[near_poses(moved, poses, self.config.loop_closure)].tolist():
                motion = inverse(self.keyframes[other].world_from_camera) @ moved
                pairs.append((self.keyframes[other].view, self.keyframes[number].view, motion))
        return pairs[:: -(-len(pairs) // MOST_PAIRS) or 1]

    def _usual_other_colors(self, pairs: Sequence[PlacedPair]) -> float:
        """What share of colours differs between keyframes of one odometry chain as far apart as those of pairs:
        exposure, light, the camera."""
        keyframes = self.keyframes
        within = [edge for edge in self.graph.edges if keyframes[edge.a].chain == keyframes[edge.b].chain]
        probes = within[:: max(len(within) // PROBES, 1)]
        known = [(keyframes[edge.a].view, keyframes[edge.b].view, edge.a_from_b) for edge in probes]
        shares = _color_differences(known, self.config)
        usual = UsualColors([separation(*known[n]) for n in shares], list(shares.values()))
        return usual.mean([separation(*pair) for pair in pairs])


def contradict(
    pairs: Sequence[PlacedPair], usual_other_colors: Callable[[Sequence[PlacedPair]], float], config: SlamConfig
) -> bool:
    """Whether pairs of views, all taken together, contradict each other; not, where there are none.

    Args:
        pairs: views as they would lie.
        usual_other_colors: what share of colours differs, of one place in this recording, between views placed to each
            other like some of the pairs, of which there is one at least.
        config: the settings.
    """
    if not pairs:
        return False
    space = np.mean([contradiction(*pair, config.free_space) for pair in pairs])
    if space > config.submaps.max_contradiction:
        return True
    colors = _color_differences(pairs, config)
    if not colors:
        return False
    usual = usual_other_colors([pairs[n] for n in colors])
    return bool(np.mean(list(colors.values())) > max(config.submaps.max_color_excess * usual, UNNOTICED))


def _color_differences(pairs: Sequence[PlacedPair], config: SlamConfig) -> dict[int, float]:
    """What share of colours differs, by number, of those pairs that share a surface."""
    shares = ((n, other_colors(*pair, config.free_space)) for n, pair in enumerate(pairs))
    return {n: share for n, share in shares if share is not None}
