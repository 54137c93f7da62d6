"""What is to be said first of estimated poses: how many, and how far they are from the given ones."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from razer.arrays import Pose
from razer.metrics.umeyama import align_views

FEWEST_COMMON = 3  # frames with both poses, to be laid upon each other


def pose_verdict(estimated: Mapping[int, Pose], given: Mapping[int, Pose], n_frames: int, n_loops: int) -> list[str]:
    """Lines of Markdown.

    Args:
        estimated: final poses (4, 4) by frame.
        given: poses (4, 4) that the frames came with, by frame, in any world.
        n_frames: how many frames were to be located.
        n_loops: closed loops.
    """
    loops = f"{n_loops} loop{'' if n_loops == 1 else 's'} closed"
    lines = [f"Estimated: **{len(estimated)} of {n_frames}** frames located, {loops}"]
    common = sorted(estimated.keys() & given.keys())
    if len(common) >= FEWEST_COMMON:
        ours, theirs = (np.array([poses[frame] for frame in common]) for poses in (estimated, given))
        gaps_cm = 100 * np.linalg.norm((align_views(theirs, ours) @ theirs - ours)[:, :3, 3], axis=1)
        farthest = common[int(gaps_cm.argmax())]
        lines.append(
            f"Given and estimated positions are **{gaps_cm.mean():.1f} cm** apart on average, "
            f"{gaps_cm.max():.1f} cm at most (frame {farthest})"
        )
    return lines
