"""Where an instance is in its room, and its size along the room's axes: what filters compare between maps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from razer.arrays import Float64Array
from razer.boxes.oriented_box import UNIT_CORNERS, OrientedBox
from razer.panoptic_map import PanopticMap

_STRAY = 0.01  # share of the surface that may lie outside the room, as behind a window or under the floor


@dataclass(frozen=True)
class RoomPlaces:
    """The frame of a room: axes as rows (3, 3), two level ones and up, and the least and largest coordinate (3,) along
    each, metres."""

    axes: Float64Array
    low: Float64Array
    high: Float64Array

    @classmethod
    def of(cls, panoptic: PanopticMap) -> Self:
        """That of a map, by its surface."""
        axes = _level_axes(panoptic.up_or_z)
        points = panoptic.mesh.vertices
        if not len(points):
            return cls(axes, np.zeros(3), np.zeros(3))
        along = points.astype(np.float64) @ axes.T
        low, high = np.quantile(along, (_STRAY, 1 - _STRAY), axis=0)
        return cls(axes, low, high)

    def facts(self, box: OrientedBox) -> dict[str, float]:
        """Size and place of a box: height_m along up, width_m and depth_m level, the longer first, as its own edges
        project; above_floor_m, of its lowest point; room_x and room_y, from 0 to 1 across the room."""
        corners = (UNIT_CORNERS * box.extent @ box.rotation.T + box.center) @ self.axes.T
        sizes = np.ptp(corners, axis=0)
        across = (self.axes @ box.center - self.low) / np.maximum(self.high - self.low, 1e-6)
        x, y = np.clip(across[:2], 0, 1).tolist()
        return {
            "height_m": float(sizes[2]),
            "width_m": float(sizes[:2].max()),
            "depth_m": float(sizes[:2].min()),
            "volume_m3": float(np.prod(box.extent)),
            "above_floor_m": float(corners[:, 2].min() - self.low[2]),
            "room_x": x,
            "room_y": y,
        }


def _level_axes(up: Float64Array) -> Float64Array:
    """Rows: two level unit vectors, and up; those of the world where up is z."""
    up = up / np.linalg.norm(up)
    aside = np.eye(3)[int(np.abs(up).argmin())] if abs(up[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    first = aside - (aside @ up) * up
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(up, first), up])
