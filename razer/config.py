"""Settings of the method: meaning with the paper's symbol, unit, what each direction costs, source."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

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
        3.0, ge=1, description="Observations that are enough however often its block was seen. Larger: the same."
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
        8, ge=4, description="Clusters of fewer occupied cells are no detection. Smaller: cups from afar, and noise."
    )
    background_gap_m: float = Field(
        0.3,
        gt=0,
        description="A cluster this far behind the largest of its mask, and farther than half that one's size, is "
        "background behind it, metres. Larger: chairs own patches of the wall; smaller: hidden middles split things.",
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
        le=2,
        description="Pairs that cost more are never matched. Lower: more fragments; higher: more mergers.",
    )
    search_margin_m: float = Field(
        0.1, ge=0, description="How far outside a detection's box the R-tree looks for tracks, metres."
    )
    box_margin_m: float = Field(
        0.025, ge=0, description="Added to every side before boxes are compared: a flat view of a wall has no volume."
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
        "track are not fused. Higher: fewer vectors of other things, and a side never seen before may be refused.",
    )


class MaintenanceSettings(Settings):
    """Votes, support, pruning and fusion of duplicates (RAZER section IV-F)."""

    interval_frames: int = Field(
        10, ge=1, description="Frames between maintenance passes. Smaller: fresher boxes, more time."
    )
    max_misses: int = Field(
        30, ge=1, description="k: frames a track may go unmatched while in view and not occluded before it is pruned."
    )
    min_support: float = Field(
        0.2,
        ge=0,
        le=1,
        description="tau_supp: share of a track's votes that must lie in voxels it won. Higher: weak tracks go sooner.",
    )
    keep_confidence: float = Field(
        0.7,
        ge=0,
        le=1,
        description="tau_conf: tracks with a hypothesis this dominant and well observed are kept despite low support.",
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
        description="Two tracks are fused when the log-odds that they are one thing, by the masks of all views and by "
        "their embeddings, are at least this. Lower: more mergers; higher: more fragments.",
    )


class ReintegrationSettings(Settings):
    """How the map follows poses that are corrected after their frames were fused."""

    enabled: bool = Field(
        False,
        description="Keep frames, so that the map can be rebuilt. Costs some 5 ms and 65 KB for each one "
        "kept, and a second volume while it is rebuilt; given poses need none of it.",
    )
    frames_per_keyframe: int = Field(
        2,
        ge=1,
        le=10,
        description="Every how many fused frames one is kept. Larger: less time and memory, ragged edges where the "
        "camera moved fast (F-score at 2 cm against all frames: 0.995 for 1, 0.991 for 2, 0.985 for 3).",
    )
    keyframe_stride: int = Field(
        4,
        ge=1,
        description="Of how many kept frames a rebuild during the run replays one; at the end all are mapped again. "
        "Larger: sooner done, rougher until the end.",
    )
    replays_per_frame: float = Field(
        0.2,
        ge=0,
        description="Frames replayed during the run for each frame fused, on average; one takes about a third of the "
        "time of a frame. 0 = the map follows at the end only.",
    )
    max_replays_per_frame: int = Field(
        2, ge=1, description="Most frames replayed after a fused one. Larger: a rebuild is done sooner, but stutters."
    )
    min_shift_voxels: float = Field(
        1.0,
        ge=0,
        description="Rebuild during the run when frames have moved by this on average, voxels at 2 m depth. Smaller: "
        "time is spent on shifts that hardly show.",
    )
    min_final_shift_voxels: float = Field(
        0.25,
        ge=0,
        description="Rebuild at the end when any frame has moved by this, voxels at 2 m depth. Smaller: more time at "
        "the end for a surface no better.",
    )
    fuse_shared_votes: float = Field(
        0.3,
        gt=0,
        le=1,
        description="After a rebuild two tracks that look alike and that no frame shows together are fused when this "
        "share of the votes of one lies in voxels the other claims too. Larger: duplicates stay.",
    )
    memory_mb: int = Field(
        512,
        ge=0,
        description="Kept frames beyond this go to a temporary file, units of 10^6 bytes: about 20,000 frames of a "
        "run. Smaller: less memory, slower rebuilds.",
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
