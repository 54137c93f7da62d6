"""Online self-calibration of the colour camera against the depth camera: lens, offset, and rolling-shutter readout.

Recordings promise that colour and depth share one pixel grid. Many do not keep it: the depth of 7-Scenes is not
registered to its colour, whose focal length is a tenth shorter, and consumer colour lenses are distorted. The
corrections are few and enter every feature's residual linearly, so the frames themselves reveal them: depth gives
the motion, features show how colour saw it. Until the corrections are known, a feature counts only in the
directions that they cannot explain, since they are solved for along with each pose.

One of them is a time: most colour sensors are read row by row, so while the camera turns, the top of an image shows
where it looked earlier than its bottom does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from razer.arrays import Float64Array, FloatArray

N_PARAMETERS = 7
SCALE, BASELINE, READOUT = 0, 5, 6  # of the parameters, those that are read one by one
MIN_DEPTH_M = 0.1  # no sensor reads nearer; a reading of 0 is none and divides nothing
NOMINAL = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
# Prior: how far recordings stray, focal length 5 %, radial terms, principal point 3 % of the focal length,
# a baseline of a few centimetres, and a readout within a frame of video.
PRIOR_SIGMA = np.array([0.05, 0.1, 0.1, 0.03, 0.03, 0.03, 0.03])
# Frames that share a keyframe, and features that share a lens, err together: their information counts by this share.
INDEPENDENT_SHARE = 0.05
INVERSE_ROUNDS = 3  # each leaves a tenth of what the one before did
STEEPEST = 4.0  # of rays: beyond it no lens sees, and radial terms explode


@dataclass(frozen=True)
class ColorCalibration:
    """The colour camera beside the depth camera: parameters (7,) = scale, two radial terms, offset x and y (all of
    normalised image coordinates), baseline in metres along x and seconds from the reading of the first row to that of
    the last, with their information (7, 7)."""

    parameters: Float64Array
    information: Float64Array

    @classmethod
    def nominal(cls) -> ColorCalibration:
        """As the recording promises: one grid for both, within the usual errors."""
        return cls(NOMINAL.copy(), np.diag(PRIOR_SIGMA**-2.0))

    def bearings(self, rays: FloatArray) -> Float64Array:
        """Bearings (N, 2), x / z and y / z as the colour camera at rest saw them, of nominal rays (N, 2)."""
        scale, radial, radial_2, x, y = self.parameters[:BASELINE]
        squared = (rays**2).sum(axis=1, keepdims=True)
        result: Float64Array = rays * (scale + squared * (radial + squared * radial_2)) + (x, y)
        return result

    def depth_rays(self, rays: FloatArray, depth_m: FloatArray) -> Float64Array:
        """Rays (N, 2) from the depth camera to what the colour camera saw along nominal rays at depths (N,)."""
        result = self.bearings(rays)
        result[:, 0] -= self.parameters[BASELINE] / np.maximum(depth_m, MIN_DEPTH_M)
        return result

    def color_rays(self, rays: FloatArray, depth_m: FloatArray) -> Float64Array:
        """Nominal rays (N, 2) along which the colour camera saw what lies along rays (N, 2) of the depth camera at
        depths (N,): the inverse of `depth_rays`, by fixed-point iteration, as radial terms are small."""
        seen = rays.astype(np.float64)
        seen[:, 0] += self.parameters[BASELINE] / np.maximum(depth_m, MIN_DEPTH_M)
        result: Float64Array = seen / self.parameters[SCALE]
        for _ in range(INVERSE_ROUNDS):
            result = (result + (seen - self.bearings(result)) / self.parameters[SCALE]).clip(-STEEPEST, STEEPEST)
        return result

    def updated(self, correction: Float64Array, likelihood: Float64Array) -> ColorCalibration:
        """The calibration after a frame whose joint solution asked for `correction` (7,), with the information (7, 7)
        its features alone hold of it; that information counts by INDEPENDENT_SHARE only."""
        information = self.information + INDEPENDENT_SHARE * likelihood
        step = np.linalg.solve(information, INDEPENDENT_SHARE * (self.information + likelihood) @ correction)
        return ColorCalibration(self.parameters + step, information)


def readout_flow(rays: FloatArray, row_times: FloatArray, turning_rad_s: Float64Array) -> Float64Array:
    """Rolling-shutter displacement (N, 2) of the bearings of rays (N, 2) per second of readout, for a camera that turns
    at (3,) rad/s; row_times (N,) are when each was read, -0.5 = with the first row, 0.5 = with the last."""
    x, y = rays.T
    wx, wy, wz = turning_rad_s
    along = wx * y - wy * x
    return row_times[:, None] * np.column_stack([wy - wz * y - x * along, wz * x - wx - y * along])


def bearing_derivatives(rays: FloatArray, flow: FloatArray) -> Float64Array:
    """Derivatives (N, 2, 7) by the parameters of the bearings of nominal rays (N, 2), which move by flow (N, 2) per
    second of readout; the baseline has none here."""
    squared = (rays**2).sum(axis=1, keepdims=True)
    result = np.zeros((len(rays), 2, N_PARAMETERS))
    result[:, :, SCALE] = rays
    result[:, :, 1] = rays * squared
    result[:, :, 2] = rays * squared**2
    result[:, 0, 3] = 1.0
    result[:, 1, 4] = 1.0
    result[:, :, READOUT] = flow
    return result
