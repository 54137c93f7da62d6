"""Noise model of the depth sensor, inflated where depth was smeared because the camera turned."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from razer.arrays import Float32Array, FloatArray
from slam.config import DepthSettings

# Squared scale of the depth residuals, in those of the sensor at rest: up to the first, nothing but noise is in them
# and depth is not smeared; from the second on it is taken to be.
UNSMEARED, SMEARED = 0.5, 1.0
MEDIAN_SIGMA = 0.6745  # median of absolute values of a normal distribution


@dataclass(frozen=True)
class DepthNoise:
    """The sensor's own noise, and `smear`: the error of depth if it was taken while the camera turned, metres at one
    metre; it counts where residuals are larger than the sensor's noise."""

    sensor: DepthSettings
    smear: float = 0.0

    def without_smear(self) -> DepthNoise:
        """The same of a camera that does not turn."""
        return DepthNoise(self.sensor)

    def at_rest(self, z: FloatArray) -> FloatArray:
        """Axial standard deviation in metres of depth at z metres (Nguyen, Izadi and Lovell, 3DIMPVT 2012)."""
        sensor = self.sensor
        return sensor.sigma_m + sensor.sigma_per_m2 * (z - sensor.sigma_from_m) ** 2

    def sigma(self, z: Float32Array, distance: Float32Array) -> Float32Array:
        """Standard deviations (N,) of depth at z metres: the sensor's own and, as far as the distances (N,) cannot be
        that, its smear. Where a shutter is global nothing is smeared, however fast the camera turns."""
        sigma: Float32Array = self.at_rest(z).astype(np.float32, copy=False)
        if self.smear == 0:
            return sigma
        sigmas = np.abs(distance[::4] / sigma[::4])
        scale = float(np.partition(sigmas, len(sigmas) // 2)[len(sigmas) // 2]) / MEDIAN_SIGMA
        doubt = min(max((scale**2 - UNSMEARED) / (SMEARED - UNSMEARED), 0.0), 1.0)
        smeared: Float32Array = np.hypot(sigma, np.float32(doubt * self.smear) * z)
        return smeared
