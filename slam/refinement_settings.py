"""Settings of the correction of given poses: how far these are believed."""

from __future__ import annotations

from pydantic import Field

from razer.settings import Settings


class RefinementSettings(Settings):
    """Given poses as priors of the pose graph. What drifts, as KinectFusion and ARKit do, is right from one moment to
    the next and wrong in the long run."""

    sigma_m: float = Field(
        0.05,
        gt=0,
        le=1,
        description="Standard deviation of the given motion between neighbouring keyframes, metres, until the end, "
        "when it is measured. Larger: registration decides; smaller: the given motion does.",
    )
    sigma_deg: float = Field(
        3.0, gt=0, le=45, description="... and of its direction, degrees. Larger or smaller: as for sigma_m."
    )
    absolute_sigma_m: float = Field(
        0.5,
        gt=0,
        le=100,
        description="Standard deviation of a given position in its world, metres, until the end, when it is measured. "
        "Larger: places seen again decide; smaller: the map stays where it was given, drift and all.",
    )
    absolute_sigma_deg: float = Field(
        5.0,
        gt=0,
        le=180,
        description="... and of a given direction, degrees. Larger or smaller: as for absolute_sigma_m.",
    )
