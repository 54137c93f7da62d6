"""Settings of the method: meaning with the paper's symbol, unit, what each direction costs, source."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from razer.config.reintegration import ReintegrationSettings
from razer.plugins import EmbedderSettings, SegmenterSettings
from razer.settings import Settings

MAX_EPS_VOXELS = 16  # clustering looks into adjacent blocks, not beyond


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
        le=1,
        description="Share of the observations of its block that a voxel needs to be surface, one at least. Larger: "
        "cleaner, but what only few frames could see is left out.",
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


class BankSettings(Settings):
    """The embedding bank E_i (RAZER section IV-E)."""

    hypotheses: int = Field(3, ge=1, le=8, description="Most hypotheses a track keeps. 1 = running mean.")
    similarity: float = Field(
        0.75,
        gt=0,
        lt=1,
        description="sigma_sim: above this similarity an observation joins a hypothesis; 0 = as alike as unlike things "
        "are on average, 1 = as two views of one thing. Higher: more hypotheses; 0.5 to 0.85 do the same on CLIP's.",
    )
    outlier: float = Field(
        0.2,
        ge=-1,
        lt=1,
        description="Observations less similar than this (0 = unlike, 1 = same) to every hypothesis of a well-known "
        "track are not fused. Higher: fewer vectors of other things, and a side never seen before may be refused; -1 = "
        "all are fused, as in the paper.",
    )
    similarity_scale: Literal["calibrated", "cosine"] = Field(
        "calibrated",
        description="What sigma_sim is compared with: similarity in units of unlike ... same, or the raw cosine to the "
        "hypothesis, as the paper: what it means depends on the embedder.",
    )
    when_full: Literal["replace", "drop"] = Field(
        "replace",
        description="A vector unlike all hypotheses of a full bank replaces the weakest if it is stronger, and else "
        "joins the nearest; or is dropped, as the paper knows no rule for it: late views count less.",
    )
    merge_hypotheses: bool = Field(
        True,
        description="Whether hypotheses whose directions agree beneath their noise are read as one. Off: as they are, "
        "as in the paper; noisy views of one thing stay apart.",
    )


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


class MapperConfig(Settings):
    """All settings of the method."""

    voxels: VoxelSettings = VoxelSettings()
    masks: MaskSettings = MaskSettings()
    lifting: LiftingSettings = LiftingSettings()
    association: AssociationSettings = AssociationSettings()
    bank: BankSettings = BankSettings()
    maintenance: MaintenanceSettings = MaintenanceSettings()
    reintegration: ReintegrationSettings = ReintegrationSettings()
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
