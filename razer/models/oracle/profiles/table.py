"""The profiles of the oracle segmenter by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models.oracle.profiles.detector_profile import DETECTOR_HARD, DetectorProfile
from razer.models.oracle.profiles.panoptic_profile import PANOPTIC_HARD, PanopticProfile
from razer.models.oracle.profiles.sam_profile import SamProfile


class SegmenterProfile(Protocol):
    """Masks that err as those of one kind of real model do."""

    def masks(self, frame: Frame) -> Masks:
        """The masks of one frame; raises BadInput when it has no instance ids."""


PROFILES: dict[str, Callable[[int], SegmenterProfile]] = {
    "sam": SamProfile,
    "detector": DetectorProfile,
    "detector-hard": lambda seed: DetectorProfile(seed, DETECTOR_HARD),
    "panoptic": PanopticProfile,
    "panoptic-hard": lambda seed: PanopticProfile(seed, PANOPTIC_HARD),
}


def segmenter_profile(name: str, seed: int) -> SegmenterProfile:
    """The profile called `name`, its draws seeded; raises BadInput for one that there is not."""
    if name not in PROFILES:
        raise BadInput(f"the oracle segmenter has no profile '{name}': choose from {', '.join(PROFILES)}")
    return PROFILES[name](seed)
