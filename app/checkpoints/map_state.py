"""What the state of a mapper consists of."""

from __future__ import annotations

from app.stored_state.state_codec import KnownObjects
from razer.boxes.oriented_box import OrientedBox, PointMoments
from razer.boxes.rtree_index import BoxIndex
from razer.class_votes import VoteCount
from razer.config import MapperConfig
from razer.detection.best_views import BestView, Region
from razer.mapper import MapperState
from razer.reintegration.frame_store import FrameStore
from razer.reintegration.kept_frames import KeptFrames
from razer.reintegration.partial_rebuild import PartialRebuild
from razer.reintegration.reintegrator import Reintegrator
from razer.similarity.cosine_histogram import CosineHistogram
from razer.similarity.similarity_scale import CalibratedScale, CosinePopulation, SimilarityScale
from razer.tracking.embedding_bank import EmbeddingBank
from razer.tracking.embedding_clusters import EmbeddingClusters
from razer.tracking.evidence.existence import Existence
from razer.tracking.evidence.pair_counts import PairCounts
from razer.tracking.evidence.view_consensus import ViewConsensus
from razer.tracking.evidence.view_novelty import ViewNovelty
from razer.tracking.panoptic_integrator import PanopticIntegrator
from razer.tracking.parts.cell_votes import CellVotes
from razer.tracking.parts.part_track import PartTrack
from razer.tracking.parts.part_tracker import PartTracker
from razer.tracking.track import Track
from razer.tracking.tracker import Tracker
from razer.volume.id_remap import InstanceIdMap
from razer.volume.support_pruning import SupportPruning
from razer.volume.surface_cache import SurfaceCache
from razer.volume.voxel_map import VoxelMap

CLASSES = (
    BestView, BoxIndex, CalibratedScale, CellVotes, CosineHistogram, CosinePopulation, EmbeddingBank,
    EmbeddingClusters, Existence, FrameStore, InstanceIdMap, KeptFrames, MapperState, OrientedBox, PairCounts,
    PanopticIntegrator, PartTrack, PartTracker, PartialRebuild, PointMoments, Region, Reintegrator, SimilarityScale,
    SupportPruning, SurfaceCache, Track, Tracker, ViewConsensus, ViewNovelty, VoteCount, VoxelMap,
)  # fmt: skip


def known_map(config: MapperConfig) -> KnownObjects:
    """What the state of a mapper of these settings may speak of."""
    return KnownObjects.of(CLASSES, config)
