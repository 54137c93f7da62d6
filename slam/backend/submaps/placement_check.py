"""Placement check: whether views, once they are placed among others, contradict what these saw.

A look-alike is like the view it was taken for, and not like the views around that one: its things stand where these
looked through, or have other colours.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from razer.arrays import Float64Array, IndexArray
from razer.geometry import inverse
from slam.backend.color_check import other_colors
from slam.backend.free_space_check import contradiction
from slam.backend.pose_graph import PoseGraph
from slam.backend.view_overlap import near_poses
from slam.config import SlamConfig
from slam.frontend.keyframes import Keyframes, View

PROBES = 40  # edges by which it is told how much colours usually differ
MOST_PAIRS = 100  # of views that are compared, some 2 ms each
UNNOTICED = 0.02  # share of other colours that tells nothing, however alike colours usually are


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
        pairs, settings = self._pairs(placed, standing, standing_from_placed), self.config.submaps
        if not pairs:
            return False
        space = np.mean([contradiction(*pair, self.config.free_space) for pair in pairs])
        if space > settings.max_contradiction:
            return True
        colors = np.mean([other_colors(*pair, self.config.free_space) for pair in pairs])
        return bool(colors > max(settings.max_color_excess * self._usual_other_colors(), UNNOTICED))

    def _pairs(
        self, placed: Iterable[int], standing: IndexArray, standing_from_placed: Float64Array
    ) -> list[tuple[View, View, Float64Array]]:
        """Views, and the motion between them; of many, some of all."""
        poses, pairs = self.keyframes.poses()[standing], list[tuple[View, View, Float64Array]]()
        for number in placed:
            moved = standing_from_placed @ self.keyframes[number].world_from_camera
            for other in standing[near_poses(moved, poses, self.config.loop_closure)].tolist():
                motion = inverse(self.keyframes[other].world_from_camera) @ moved
                pairs.append((self.keyframes[other].view, self.keyframes[number].view, motion))
        return pairs[:: -(-len(pairs) // MOST_PAIRS) or 1]

    def _usual_other_colors(self) -> float:
        """What share of colours differs between keyframes of one odometry chain: exposure, light, the camera."""
        keyframes = self.keyframes
        within = [edge for edge in self.graph.edges if keyframes[edge.a].chain == keyframes[edge.b].chain]
        probes = within[:: max(len(within) // PROBES, 1)]
        shares = [
            other_colors(keyframes[e.a].view, keyframes[e.b].view, e.a_from_b, self.config.free_space) for e in probes
        ]
        return float(np.mean(shares)) if shares else 0.0
