"""Where the colour camera really looks, learnt while tracking.

Recordings promise that colour and depth share one pixel grid. Many do not keep it: the depth of 7-Scenes is not
registered to its colour, whose focal length is a tenth shorter, and consumer colour lenses are distorted. The
corrections are few and enter every feature's residual linearly, so the frames themselves tell them: depth gives
the motion, features say how colour saw it. Until they are known, a feature counts only in the directions that
they cannot explain, since they are solved for along with each pose.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from razer.geometry import Array

N_PARAMETERS = 6
NOMINAL = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
# How far recordings are believed to stray: focal length 5 %, radial terms, principal point 3 % of the focal length,
# and a baseline of a few centimetres.
PRIOR_SIGMA = np.array([0.05, 0.1, 0.1, 0.03, 0.03, 0.03])
# Frames that share a keyframe, and features that share a lens, err together.
BELIEF = 0.05


@dataclass(frozen=True)
class ColorCamera:
    """The colour camera beside the depth camera: parameters (6,) = scale, two radial terms, offset x and y (all of
    normalised image coordinates) and baseline in metres along x, with their information (6, 6)."""

    parameters: Array
    information: Array

    @classmethod
    def nominal(cls) -> ColorCamera:
        """As the recording promises: one grid for both, within the usual errors."""
        return cls(NOMINAL.copy(), np.diag(PRIOR_SIGMA**-2.0))

    def bearings(self, rays: NDArray[np.floating]) -> Array:
        """Bearings (N, 2), x / z and y / z as the colour camera saw them, of nominal rays (N, 2)."""
        return bearing_derivatives(rays)[..., :5] @ self.parameters[:5]

    def depth_rays(self, rays: NDArray[np.floating], depth_m: NDArray[np.floating]) -> Array:
        """Rays (N, 2) from the depth camera to what the colour camera saw along nominal rays at depths (N,)."""
        result = self.bearings(rays)
        result[:, 0] -= self.parameters[5] / np.maximum(depth_m, 0.1)
        return result

    def learnt(self, correction: Array, likelihood: Array) -> ColorCamera:
        """The camera after a frame whose joint solution asked for `correction` (6,), with the information (6, 6) its
        features alone hold of it; that information is believed by the share BELIEF only."""
        information = self.information + BELIEF * likelihood
        step = np.linalg.solve(information, BELIEF * (self.information + likelihood) @ correction)
        return ColorCamera(self.parameters + step, information)


def bearing_derivatives(rays: NDArray[np.floating]) -> Array:
    """Derivatives (N, 2, 6) of the bearings of nominal rays (N, 2) by the parameters; the baseline has none here."""
    squared = (rays**2).sum(axis=1, keepdims=True)
    result = np.zeros((len(rays), 2, N_PARAMETERS))
    result[:, :, 0] = rays
    result[:, :, 1] = rays * squared
    result[:, :, 2] = rays * squared**2
    result[:, 0, 3] = 1.0
    result[:, 1, 4] = 1.0
    return result
