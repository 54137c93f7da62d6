"""Component times of the paper's runtime table, and those of a run: which of its stages each component is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

STAGES_BY_COMPONENT = {
    "2D segmentation": ("segment",),
    "OBB detection": ("lift",),
    "OBB tracking": ("associate", "vote", "maintain"),
    "embedding": ("embed",),
}
PER_FRAME = "all"
# Milliseconds a frame; super-points and the graph of VolumePanoptic stand where the paper's table puts them.
PUBLISHED_MS: dict[str, tuple[float | None, ...]] = {
    "VolumePanoptic": (216.0, 70.3, 127.2, None, 413.5),
    "RAZER (paper)": (82.3, 1.7, 18.4, 0.8, 103.2),
}
NOTES = (
    "VolumePanoptic adds 333.4 ms once a map; the paper's embedding is the update of vectors, ours makes them too",
    "stages of ours: "
    + "; ".join(f"{component} = {' + '.join(stages)}" for component, stages in STAGES_BY_COMPONENT.items())
    + "; not in it: decoding, poses, integration, reintegration, the timeline",
)


def component_times(timings: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Mean milliseconds a frame of each component and of all of them, the mean over the runs whose timings.json these
    are."""
    each = [_of_run(one) for one in timings]
    means = {name: float(np.mean([run[name] for run in each])) for name in STAGES_BY_COMPONENT}
    return {name: round(ms, 2) for name, ms in {**means, PER_FRAME: sum(means.values())}.items()}


def _of_run(timings: Mapping[str, Any]) -> dict[str, float]:
    """Total times of the stages, over the frames."""
    frames = max(int(timings["frames"]), 1)
    total_s = {stage: float(numbers["total_s"]) for stage, numbers in timings["stages"].items()}
    return {
        component: 1000 * sum(total_s.get(stage, 0.0) for stage in stages) / frames
        for component, stages in STAGES_BY_COMPONENT.items()
    }
