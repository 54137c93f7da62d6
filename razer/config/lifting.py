"""Settings of masks and of their lifting to 3D detections."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from razer.settings import Settings


class MaskSettings(Settings):
    """Which masks are lifted, and how far their borders are trusted."""

    min_pixels: int = Field(
        64, ge=1, description="Smaller masks are dropped; pixels at 640x480, scaled with the image (OnlineAnySeg)."
    )
    min_score: float = Field(0.25, ge=0, le=1, description="Masks the model trusts less are dropped.")
    min_valid_depth: float = Field(
        0.2, ge=0, le=1, description="Share of a mask that needs depth. Lower: shiny things stay, with wild boxes."
    )
    shrink_pixels: int = Field(
        2, ge=0, le=20, description="Pixels taken off each mask's border, at 640x480, so that depth edges do not bleed."
    )


class LiftingSettings(Settings):
    """From masks to 3D detections (RAZER section IV-B)."""

    dbscan_eps_m: float = Field(
        0.05,
        gt=0,
        description="DBSCAN's epsilon, metres; at least two voxels are used. Larger: joins across wider gaps.",
    )
    dbscan_min_points: int = Field(10, ge=1, description="DBSCAN's core-point count, on cells of the map's voxel size.")
    min_cells: int = Field(
        8,
        ge=4,
        description="Masks and clusters of fewer occupied cells are no detection. Smaller: cups from afar, and noise.",
    )
    background_gap_m: float = Field(
        0.3,
        gt=0,
        description="What lies this far behind the clusters of a mask before it, and farther than half the size of "
        "the nearest one, is background, metres. Larger: chairs own patches of the wall; smaller: hidden middles split "
        "things.",
    )
    drop_background: bool = Field(
        True,
        description="Whether background is left out. Off: the paper's way, what is seen through a thing is its own.",
    )
    detections: Literal["mask", "cluster"] = Field(
        "mask",
        description="'mask': all of a mask is one detection; 'cluster' is the paper's way, each DBSCAN cluster is one "
        "and noise is dropped: what a mask joins falls apart, and so does what something nearer hides in part.",
    )
    points: Literal["cells", "readings"] = Field(
        "cells",
        description="What moments and boxes count: occupied cells, or depth readings as the paper: near surface then "
        "outweighs far surface.",
    )
    box_center: Literal["extents", "centroid"] = Field(
        "extents",
        description="Centre of a detection's box: the middle of its extents, or the centroid as the paper: such a box "
        "does not hold its points.",
    )
