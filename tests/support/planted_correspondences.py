"""Correspondences of known motions, as colour cameras of known parameters see them."""

from __future__ import annotations

import numpy as np

from razer.geometry import inverse
from slam.frontend.color_calibration import readout_flow
from slam.frontend.gauss_newton.correspondences import Correspondences
from slam.se3 import exp_se3


def planted(parameters, n, rng, turning=((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))):
    """Sightings whose rays a colour camera of the given parameters saw while it turned so, and the true motion."""
    truth = exp_se3(rng.normal(0, [0.1, 0.1, 0.1, 0.05, 0.05, 0.05]))
    points = np.column_stack([rng.uniform(-1.2, 1.2, (n, 2)), rng.uniform(1.5, 3.5, n)])
    there = points @ inverse(truth)[:3, :3].T + inverse(truth)[:3, 3]
    turning = np.array(turning)
    rays, flow = zip(
        *(
            observed(p + np.array([parameters[5], 0, 0]), parameters, w)
            for p, w in zip((points, there), turning, strict=True)
        ),
        strict=True,
    )
    return Correspondences(rays[0], points[:, 2], rays[1], np.full(n, 1.5 / 525), *flow), truth


def observed(points, parameters, turning):
    """Nominal rays that have the bearings of the points, by iteration, and their flow: each point is seen by the
    camera as it stands when the row is read on which it appears."""
    bearing = points[:, :2] / points[:, 2:]
    rays, flow = bearing, np.zeros_like(bearing)
    for _ in range(40):
        row_times = rays[:, 1]  # of an image that spans a bearing of 1
        flow = readout_flow(rays, row_times, turning)
        squared = (rays**2).sum(axis=1, keepdims=True)
        radial = parameters[0] + parameters[1] * squared + parameters[2] * squared**2
        rays = (bearing - parameters[3:5] - parameters[6] * flow) / radial
    return rays, flow
