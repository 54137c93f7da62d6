"""Orthographic top view of a map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from razer.arrays import Float64Array, FloatArray

_AXES = "xyz"
_NEARLY_UPRIGHT = np.cos(np.radians(20))  # an axis within this of upwards is taken to point there


@dataclass(frozen=True)
class TopView:
    """Orthographic projection onto the floor: unit vectors right and away (3,), and labels of their axes."""

    right: Float64Array
    away: Float64Array
    names: tuple[str, str]

    @classmethod
    def of(cls, up: Float64Array) -> TopView:
        """The view against `up` (3,): along the world's own axes where one of them points nearly upwards."""
        up = up / np.linalg.norm(up)
        upright = int(np.abs(up).argmax())
        if abs(up[upright]) < _NEARLY_UPRIGHT:
            right = np.cross(up, np.eye(3)[np.abs(up).argmin()])
            right /= np.linalg.norm(right)
            return cls(right, np.cross(up, right), ("along the floor, m", "across, m"))
        first, second = (upright + 1) % 3, (upright + 2) % 3
        if up[upright] < 0:
            first, second = second, first
        return cls(np.eye(3)[first], np.eye(3)[second], (f"{_AXES[first]}, m", f"{_AXES[second]}, m"))

    def project(self, points: FloatArray) -> Float64Array:
        """Points (..., 3) projected into the view: (..., 2), metres."""
        return np.stack([points @ self.right, points @ self.away], axis=-1)
