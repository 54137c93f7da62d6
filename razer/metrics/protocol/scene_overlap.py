"""Whether a prediction is of the scene that the truth is of."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from razer.metrics.surface.surface_errors import SurfaceDistances

NEAR_M = 0.05
# Maps of other rooms and apartments, which have the floor and a grid of walls in common with the truth, were within
# 5 cm of it for up to 0.72 of a surface, with up to 0.09 of the instances matched by chance; maps of the same scene for
# 0.97 and more. Where poor poses lie between these, the instances still tell.
_MIN_SHARE = 0.8
_MIN_RECALL = 0.2


class SceneOverlap(NamedTuple):
    """Shares of the predicted and of the true surface within NEAR_M of the other one."""

    predicted: float
    truth: float


def scene_overlap(distances: SurfaceDistances | None) -> SceneOverlap | None:
    """The shares, None where the prediction has no surface of its own."""
    if distances is None:
        return None
    return SceneOverlap(
        predicted=float(np.mean(distances.to_truth <= NEAR_M)), truth=float(np.mean(distances.to_predicted <= NEAR_M))
    )


def is_of_another_scene(overlap: SceneOverlap | None, n_matched: int | None, n_truth: int | None) -> bool:
    """Whether neither surface lies mostly on the other, and hardly any true instance was matched. A map of a part of
    the scene lies on the truth, and the truth of a part of it on the map: the larger share decides."""
    if overlap is None or max(overlap) >= _MIN_SHARE:
        return False
    return not n_truth or (n_matched or 0) < _MIN_RECALL * n_truth
