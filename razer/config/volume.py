"""Settings of the volume: voxels, range of depth, what is surface and how the mesh is labelled."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from razer.settings import Settings


class VoxelSettings(Settings):
    """The volume V(p) = {d, w, c, l, h} (RAZER eq. 1)."""

    voxel_size_m: float = Field(
        0.02, gt=0.001, le=0.2, description="Edge of a voxel, metres. Smaller: finer surface, cubically more memory."
    )
    truncation_voxels: float = Field(
        5.0,
        ge=2,
        le=20,
        description="Truncation distance tau, in voxels. Smaller: thin parts survive, noise tears holes.",
    )
    depth_min_m: float = Field(0.1, ge=0, description="Nearer readings are ignored, metres.")
    depth_max_m: float = Field(
        5.0, gt=0, le=50, description="Farther readings are ignored, metres. Larger: more surface, noisier (z squared)."
    )
    histogram_slots: int = Field(
        4, ge=1, le=16, description="K, instances remembered in a voxel's histogram h. Each costs 6 bytes a voxel."
    )
    carve_every: int = Field(
        10, ge=0, description="Frames between passes of space carving; 0 = never: moved objects leave ghosts."
    )
    surface_share: float = Field(
        0.05,
        ge=0,
        le=2,
        description="Share of the observations of its block that a voxel needs to be surface, one at least. Larger: "
        "cleaner, but what only few frames could see is left out; 2 = surface_weight observations wherever it is.",
    )
    surface_weight: float = Field(
        3.0,
        ge=1,
        description="Observations that are enough however often its block was seen. Larger: cleaner where many "
        "frames saw a place, and what only few of them could see is left out.",
    )
    vertex_labels: Literal["votes", "voxel"] = Field(
        "votes",
        description="Instance of a vertex: 'votes' adds up those of the eight voxels around it, 'voxel' is the paper's "
        "way, the label of the nearest voxel: ragged where masks end.",
    )
    seam_rings: int = Field(
        3,
        ge=0,
        le=20,
        description="Edges over which labels spread to vertices that nobody owns. 0 = none, as the paper: seams "
        "between instances; larger: small things without a label go to what they stand on.",
    )

    @property
    def truncation_m(self) -> float:
        """The truncation distance tau in metres."""
        return self.truncation_voxels * self.voxel_size_m
