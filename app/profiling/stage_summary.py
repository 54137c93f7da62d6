"""Statistics of stage durations, as timings.json and the tables have them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

# In the order of a frame's life, whatever process they run in.
STAGES = ("decode", "pose", "integrate", "segment", "embed", "lift", "associate", "vote", "maintain", "rebuild", "log")


def stage_summaries(durations_ms: Mapping[str, Sequence[float]]) -> dict[str, dict[str, float]]:
    """The summary of each stage, in the order of STAGES; unknown ones come last."""
    return {name: summarize(durations_ms[name]) for name in sorted(durations_ms, key=_rank)}


def summarize(durations_ms: Sequence[float]) -> dict[str, float]:
    """Median, 95th percentile (milliseconds) and sum (seconds) of the durations of one stage."""
    median, p95 = np.percentile(durations_ms, [50, 95]) if durations_ms else (0.0, 0.0)
    return {
        "median_ms": round(float(median), 3),
        "p95_ms": round(float(p95), 3),
        "total_s": round(sum(durations_ms) / 1e3, 4),
    }


def _rank(stage: str) -> int:
    return STAGES.index(stage) if stage in STAGES else len(STAGES)
