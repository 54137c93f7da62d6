"""Open directions: nothing that the camera saw says how far it moved along them, as in front of a blank wall or along a
bare corridor."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from razer.arrays import Float64Array
from slam.frontend.icp import IcpResult
from slam.pose_edge import EDGE_SHARE, OPEN_INFORMATION
from slam.report import OpenStretch
from slam.se3 import adjoint

OPEN_M = 0.1  # standard deviation of a frame's shift in front of its keyframe from which on a direction is open
MAX_GAP, MIN_FRAMES = 5, 3  # frames: shorter gaps part no stretch, and fewer make none


class OpenDirections:
    """Looks on as frames are registered."""

    def __init__(self) -> None:
        self._n_frames = 0
        self._open: list[tuple[int, int, Float64Array]] = []  # number of a frame, its index, and the information

    def see(self, index: int, result: IcpResult) -> None:
        """Take in how the next frame was registered."""
        self._n_frames += 1
        moved = adjoint(result.target_from_source)  # from the keyframe's axes to the camera's own
        information = EDGE_SHARE * moved.T @ result.information @ moved
        if _least_certain(information, 1.0)[0] > OPEN_M:
            self._open.append((self._n_frames, index, information))

    def stretches(self, unit: float) -> tuple[OpenStretch, ...]:
        """The stretches, in which registrations are off by `unit` of the sigmas that they count with."""
        found: list[list[tuple[int, int, Float64Array]]] = []
        for number, index, information in self._open:
            sigma_m, axis = _least_certain(information, unit)
            if sigma_m <= OPEN_M:
                continue
            if not found or number - found[-1][-1][0] > MAX_GAP:
                found.append([])
            found[-1].append((number, index, axis))
        return tuple(
            OpenStretch(stretch[0][1], stretch[-1][1], _mean_axis(axis for _, _, axis in stretch))
            for stretch in found
            if len(stretch) >= MIN_FRAMES
        )


def _least_certain(information: Float64Array, unit: float) -> tuple[float, Float64Array]:
    """The standard deviation of the shift, metres, along its least certain axis, and that axis (3,)."""
    values, axes = np.linalg.eigh((information + information.T) / 2 / unit**2)
    covariance = axes / values.clip(OPEN_INFORMATION, None) @ axes.T
    variances, directions = np.linalg.eigh(covariance[3:, 3:])
    return float(np.sqrt(variances[-1])), directions[:, -1]


def _mean_axis(axes: Iterable[Float64Array]) -> Float64Array:
    """Of axes that have no sign."""
    return np.linalg.eigh(sum(np.outer(axis, axis) for axis in axes))[1][:, -1]
