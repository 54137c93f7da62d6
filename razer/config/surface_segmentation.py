"""Settings of the segmentation of the fused surface."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from razer.settings import Settings

_VOXELS_OF_SUPERVOXEL = 3  # less, and normals are those of single triangles


class SurfaceSegmentationSettings(Settings):
    """How the finished surface is segmented by shape and colour, in place of the masks of single frames."""

    use: Literal["auto", "always", "never"] = Field(
        "auto",
        description="Whether the finished map's instances are segments of its surface: 'auto', where the segmenter is "
        "geometric. The masks' own instances (never) are parts and leftovers more often: AP50 0.32 in place of 0.55.",
    )
    structure: Literal["auto", "always", "never"] = Field(
        "auto",
        description="Whether a plane of wall, floor or ceiling goes to the stuff that has most of it, at the end: "
        "'auto', where masks are pieces of class maps, whose borders are coarse. Never: half a floor may be cupboard. "
        "Segments of the surface (`use`) know their structure without it.",
    )
    supervoxel_m: float = Field(
        0.06,
        gt=0.01,
        le=0.5,
        description="Width of the pieces that merge to things, metres; at least three voxels. Smaller: finer borders "
        "and smaller things, more time.",
    )
    merge_probability: float = Field(
        0.6,
        ge=0.05,
        le=0.99,
        description="How probably two pieces that touch are of one thing, at least, to be merged. Higher: more and "
        "smaller segments; lower: things that touch are merged. From 0.55 to 0.7 AP50 is the same within 0.02.",
    )
    min_area_m2: float = Field(
        0.008,
        ge=0,
        description="Least surface of a thing, square metres; a cup has 0.02, of which half may be "
        "seen. Larger: fewer specks along creases, and small things are lost.",
    )
    min_score: float = Field(
        0.15,
        ge=0,
        le=1,
        description="Least score of a thing, the probability that it is a whole one; what is below is nobody's. "
        "Higher: fewer fragments, and things are lost. At 0.15 most fragments go, and 95 % of the surface stays.",
    )

    def at_voxels(self, voxel_size_m: float) -> SurfaceSegmentationSettings:
        """The same for a surface of such voxels: supervoxels are no narrower than three of them."""
        return self.model_copy(update={"supervoxel_m": max(self.supervoxel_m, _VOXELS_OF_SUPERVOXEL * voxel_size_m)})
