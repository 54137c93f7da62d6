"""Settings of the method: meaning with the paper's symbol, unit, what each direction costs, source."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from razer.config.association import AssociationSettings
from razer.config.bank import BankSettings
from razer.config.lifting import LiftingSettings, MaskSettings
from razer.config.maintenance import MaintenanceSettings
from razer.config.reintegration import ReintegrationSettings
from razer.config.surface_segmentation import SurfaceSegmentationSettings
from razer.config.volume import VoxelSettings
from razer.plugins import EmbedderSettings, SegmenterSettings
from razer.settings import Settings

__all__ = [
    "AssociationSettings",
    "BankSettings",
    "LiftingSettings",
    "MaintenanceSettings",
    "MapperConfig",
    "MaskSettings",
    "ReintegrationSettings",
    "SurfaceSegmentationSettings",
    "VoxelSettings",
]

MAX_EPS_VOXELS = 16  # clustering looks into adjacent blocks, not beyond


class MapperConfig(Settings):
    """All settings of the method."""

    granularity: Literal["object", "part"] = Field(
        "object",
        description="What an instance of the map is: a whole thing, of which parts are kept as children; or each part "
        "that masks showed view after view, and what is left of its whole: more instances, and chairs in pieces.",
    )
    voxels: VoxelSettings = VoxelSettings()
    masks: MaskSettings = MaskSettings()
    lifting: LiftingSettings = LiftingSettings()
    association: AssociationSettings = AssociationSettings()
    bank: BankSettings = BankSettings()
    maintenance: MaintenanceSettings = MaintenanceSettings()
    reintegration: ReintegrationSettings = ReintegrationSettings()
    surface_segmentation: SurfaceSegmentationSettings = SurfaceSegmentationSettings()
    segmenter: SegmenterSettings = SegmenterSettings()
    embedder: EmbedderSettings = EmbedderSettings()

    @model_validator(mode="after")
    def _reach_fits_blocks(self) -> MapperConfig:
        if self.lifting.dbscan_eps_m / self.voxels.voxel_size_m >= MAX_EPS_VOXELS:
            raise ValueError(
                f"lifting.dbscan_eps_m must be less than {MAX_EPS_VOXELS} voxels, and voxels.voxel_size_m is "
                f"{self.voxels.voxel_size_m:g}"
            )
        return self
