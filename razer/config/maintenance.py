"""Settings of tracks over time: votes, moments, pruning, fusion of duplicates."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from razer.settings import Settings


class MaintenanceSettings(Settings):
    """Votes, support, pruning and fusion of duplicates (RAZER section IV-F)."""

    interval_frames: int = Field(
        10, ge=1, description="Frames between maintenance passes. Smaller: fresher boxes, more time."
    )
    tentative: bool = Field(
        True,
        description="Whether a track is an instance only once it is more likely a thing than a phantom. Off: at once, "
        "as in the paper; what was detected by mistake is an instance, too.",
    )
    pruning: Literal["existence", "support"] = Field(
        "existence",
        description="Tracks are pruned by the log-odds that they exist; or as the paper, by max_misses, min_support "
        "and keep_confidence, which 'existence' does not read: what is hidden counts as missed.",
    )
    max_misses: int = Field(
        30,
        ge=1,
        description="k: consecutive frames unmatched with its centre in the frustum, or of low support, before a track "
        "is pruned by support. Larger: phantoms stay; smaller: things hidden or seldom detected go.",
    )
    min_support: float = Field(
        0.05,
        ge=0,
        le=1,
        description="tau_supp: r_i, the share of its box's volume that voxels with its label fill, below which support "
        "is low. Higher: weak tracks go sooner, and large hollow things with them.",
    )
    keep_confidence: float = Field(
        0.7,
        ge=0,
        le=1,
        description="tau_conf: tracks with a hypothesis of more confidence max c_j than this are not pruned by "
        "support. Higher: more are pruned; a few good views reach 0.7.",
    )
    label_votes: Literal["mask", "box"] = Field(
        "mask",
        description="Which voxels vote for a track: those of the observed surface within its mask; or as the paper, "
        "all within its box: things on a table are the table's, too. Several times the time.",
    )
    moments: Literal["voxels", "sums"] = Field(
        "voxels",
        description="Moments and box are taken anew from the track's voxels; or as the paper, sums over all detections "
        "for ever: what a wrong mask added is never forgotten.",
    )
    fuse_duplicates: bool = Field(
        True, description="Whether duplicates are fused by view consensus. Off, as the paper: fragments stay fragments."
    )
    withdraw_votes: bool = Field(
        True,
        description="Whether a voxel loses a vote for an instance that the frame shows elsewhere. Off: what a mask "
        "spilled over stays, and small things detected now and then belong to what they stand on.",
    )
    spare_others: bool = Field(
        True,
        description="Whether a mask takes no voxel of tracks that it covers whole, though more views hold them apart "
        "from its own. Off, as the paper: where views are few, one mask that joined two things gives one to the other.",
    )
    min_confidence: float = Field(
        0.3,
        ge=0,
        le=1,
        description="Confidence alpha below which a track is no instance when the run ends. Higher: fewer fragments, "
        "and small things vanish.",
    )
    fuse_log_odds: float = Field(
        1.0,
        ge=-20,
        le=20,
        description="Two tracks are fused when the log-odds that they are one thing, by the masks of all views and by "
        "their embeddings, are at least this, natural logarithm. Lower: more mergers; higher: more fragments.",
    )
