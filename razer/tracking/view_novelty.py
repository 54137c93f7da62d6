"""View novelty: how much a frame says beyond the one before it, by how far the camera moved."""

from __future__ import annotations

import numpy as np

from razer.arrays import Pose

# Camera motion after which the masks of a frame are errors of their own, and no repetition of the last frame's.
NEW_VIEW_M = 0.15
NEW_VIEW_RAD = np.deg2rad(10.0)
# A camera at rest still sees another noise: what flickers is not there.
MIN_NOVELTY = 0.25


class ViewNovelty:
    """Counts views along a path: the same for few frames and for many, once they are a step apart at most."""

    def __init__(self) -> None:
        self._last: Pose | None = None

    def of(self, world_from_camera: Pose) -> float:
        """Share of a view, in (0, 1], that a frame at this pose is after the frames before it."""
        last, self._last = self._last, world_from_camera
        if last is None:
            return 1.0
        step_m = float(np.linalg.norm(world_from_camera[:3, 3] - last[:3, 3]))
        cosine = (np.trace(last[:3, :3].T @ world_from_camera[:3, :3]) - 1) / 2
        step = step_m / NEW_VIEW_M + float(np.arccos(np.clip(cosine, -1, 1))) / NEW_VIEW_RAD
        return min(1.0, max(MIN_NOVELTY, step))
