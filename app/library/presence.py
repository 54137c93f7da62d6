"""When something counts as present in any of many maps: the more instances are asked, the surer the best must be."""

from __future__ import annotations

from razer.query.ranking import PRESENT


def threshold_among(n_instances: int) -> float:
    """The least score of a hit by its looks among so many instances."""
    return PRESENT
