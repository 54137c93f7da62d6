"""View novelty: how much a frame says beyond those before it, by how far the camera moved."""

from __future__ import annotations

import numpy as np

from razer.arrays import Pose

# Camera motion after which the masks of a frame are errors of their own, and no repetition of earlier ones.
NEW_VIEW_M = 0.15
NEW_VIEW_RAD = np.deg2rad(10.0)
# A camera at rest still sees another noise: so many views more from one place, however long it stays, and each frame
# takes this share of what is left of them.
VIEWS_AT_REST = 1.0
REST_RATE = 0.05


class ViewNovelty:
    """Counts views along a path: the same for few frames and for many, once they are a step apart at most."""

    def __init__(self) -> None:
        self._place: Pose | None = None
        self._counted = 0.0  # views since the camera came to this place

    def of(self, world_from_camera: Pose) -> float:
        """Share of a view, in [0, 1], that a frame at this pose is after the frames before it."""
        if self._place is None:
            self._place = world_from_camera
            return 1.0
        away = _views_between(self._place, world_from_camera)
        at_rest = self._counted + REST_RATE * max(0.0, VIEWS_AT_REST - self._counted)
        counted, self._counted = self._counted, max(away, at_rest)
        novelty = min(1.0, self._counted - counted)
        if away >= 1:  # a new place; a tremble of the hand does not add up to one
            self._place, self._counted = world_from_camera, 0.0
        return novelty


def _views_between(one: Pose, other: Pose) -> float:
    """How far two poses are apart, in views."""
    step_m = float(np.linalg.norm(other[:3, 3] - one[:3, 3]))
    cosine = (np.trace(one[:3, :3].T @ other[:3, :3]) - 1) / 2
    return step_m / NEW_VIEW_M + float(np.arccos(np.clip(cosine, -1, 1))) / float(NEW_VIEW_RAD)
