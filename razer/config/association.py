"""Settings of association: the cost of a pair, the gate, and what joins without a match."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from razer.settings import Settings


class AssociationSettings(Settings):
    """Which detection belongs to which track: M = w_v V + w_s S (RAZER eq. 8)."""

    geometry_distance: Literal["visible", "containment", "paper"] = Field(
        "visible",
        description="V_ij: 'visible' compares the mask with the track's own voxels visible in the frame; 'containment' "
        "uses box intersection over the smaller volume; 'paper' uses 1 - IoU of the oriented boxes.",
    )
    weight_geometry: float = Field(0.6, ge=0, le=1, description="w_v, share of the geometric distance in the cost.")
    weight_semantic: float = Field(0.4, ge=0, le=1, description="w_s, share of the embedding distance in the cost.")
    gate: float = Field(
        0.5,
        gt=0,
        le=3,
        description="Pairs that cost more are never matched. Lower: more fragments; higher: more mergers; 3 = no gate.",
    )
    semantic_distance: Literal["calibrated", "euclidean"] = Field(
        "calibrated",
        description="S_ij: 'calibrated' is 1 - P(same | similarity), in [0, 1]; 'euclidean' is the paper's, the "
        "distance to the nearest hypothesis, in [0, 2], for which the gate is too narrow.",
    )
    search_margin_m: float = Field(
        0.1, ge=0, description="How far outside a detection's box the R-tree looks for tracks, metres."
    )
    box_margin_m: float = Field(
        0.025, ge=0, description="Added to every side before boxes are compared: a flat view of a wall has no volume."
    )
    join: bool = Field(
        True,
        description="Whether detections left over by the matching may join tracks. Off: strictly one to one, as the "
        "paper; a mask cut in two founds a second instance.",
    )
    join_share: float = Field(
        0.5,
        gt=0,
        le=1,
        description="A detection left over by the matching joins the track that already owns this share of its cells.",
    )
    join_distance: float = Field(
        0.5,
        ge=0,
        le=2,
        description="... unless its embedding is farther (0 = same, 1 = unlike). Larger: fewer splits, small things "
        "vanish.",
    )
