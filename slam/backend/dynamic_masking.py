"""Dynamic masking: what stands where earlier keyframes looked through has moved there, and may move on (free-space
violation, as in Palazzolo et al., ReFusion, IROS 2019).

Keyframes that show it lead tracking along with it: people who cover a third of the view before a bare wall fit better
than the wall.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from razer.arrays import BoolArray, Float64Array, IndexArray
from razer.geometry import inverse
from slam.backend.view_checks.free_space_check import standing_readings
from slam.backend.view_overlap import near_poses
from slam.config import SlamConfig
from slam.frontend.keyframes import MIN_POINTS, Keyframe, Keyframes, View

MOST_COMPARED = 12  # keyframes, some 0.5 ms each
LEAST_SHARE = 0.01  # of a view that moved; less draws no pose along
BLOCK = np.ones((3, 3), np.uint8)  # pixels: fewer are noise, and so far beside it the readings mix


@dataclass(frozen=True)
class DynamicMasking:
    """Holds views against the free space of keyframes that odometry joins them with: look-alikes, which others are
    told by what stands where these looked through, are not masked away."""

    keyframes: Keyframes
    config: SlamConfig

    def static_part(self, view: View, before: Keyframe, world_from_camera: Float64Array, travelled_m: float) -> View:
        """A view without what moved.

        Args:
            view: the view.
            before: the keyframe that odometry led from.
            world_from_camera: (4, 4) the view's pose.
            travelled_m: how far the camera had travelled.
        """
        standing = np.zeros(view.sparse.depth.shape, np.uint8)
        for number in self._earlier(before, world_from_camera):
            keyframe = self.keyframes[number]
            keyframe_from_view = inverse(keyframe.world_from_camera) @ world_from_camera
            drift_m = self.config.loop_closure.drift_m_per_m * (travelled_m - keyframe.travelled_m)
            pixel, stands = standing_readings(view, keyframe.view, keyframe_from_view, self.config.free_space, drift_m)
            standing.ravel()[pixel[stands]] = 1
        moved: BoolArray = cv2.dilate(cv2.morphologyEx(standing, cv2.MORPH_OPEN, BLOCK), BLOCK) > 0
        if moved.mean() <= LEAST_SHARE:
            return view
        static = view.without(moved)
        return static if static.pyramid.n_points >= MIN_POINTS else view

    def _earlier(self, before: Keyframe, world_from_camera: Float64Array) -> IndexArray:
        numbers = np.flatnonzero(self.keyframes.chains() == before.chain)
        poses = self.keyframes.poses()[numbers]
        return numbers[near_poses(world_from_camera, poses, self.config.loop_closure)][:MOST_COMPARED]
