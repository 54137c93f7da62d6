"""Panoptic integration of one observation at a time: the TSDF volume, the tracks in it, and the votes that join both
(RAZER section IV-G)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set

import numpy as np

from razer.arrays import Int32Array
from razer.boxes.oriented_box import OrientedBox
from razer.config import MapperConfig
from razer.detection.lifting import Detection
from razer.detection.observed_surface import ObservedSurface
from razer.detection.perception import Observation
from razer.stages import stage
from razer.tracking.evidence.pair_counts import Pair
from razer.tracking.evidence.view_novelty import ViewNovelty
from razer.tracking.label_overlap import LabelOverlap
from razer.tracking.parts.part_tracker import PartFrame, PartTracker
from razer.tracking.step_result import StepResult
from razer.tracking.stuff import meeting_pairs
from razer.tracking.track import Track
from razer.tracking.tracker import Tracker
from razer.volume.box_voting import vote_in_boxes
from razer.volume.label_voting import vote
from razer.volume.space_carving import carve
from razer.volume.support_pruning import SupportPruning, support_ratios
from razer.volume.surface_cache import SurfaceCache, points_by_instance
from razer.volume.voxel_map import VoxelMap
from razer.volume.won_shares import won_shares

TRACKS_AT_ONCE = 32  # of passes over many tracks, to bound the voxels that are held besides the map


class PanopticIntegrator:
    """A volume and its tracks. `Mapper` fills one as frames come; the last pass of a `Reintegrator` fills another."""

    def __init__(self, config: MapperConfig, voxels: VoxelMap, tracker: Tracker) -> None:
        self.config = config
        self.voxels = voxels
        self.tracker = tracker
        self.parts = PartTracker(config, tracker.scale)
        self._surface = SurfaceCache()
        self._novelty = ViewNovelty()
        by_support = config.maintenance.pruning == "support"
        self._support_pruning = SupportPruning(config.maintenance) if by_support else None
        self._meeting: set[Pair] = set()
        self._n_frames = 0

    def successor(self, carve_every: int) -> PanopticIntegrator:
        """An empty one that gives new ids, and carves free space every `carve_every` frames; 0 = never."""
        voxel_settings = self.config.voxels.model_copy(update={"carve_every": carve_every})
        config = self.config.model_copy(update={"voxels": voxel_settings})
        tracker = Tracker(config, self.tracker.newest_id, self.tracker.scale)
        return PanopticIntegrator(config, self.voxels.empty_copy(), tracker)

    def fuse(self, observation: Observation, *, spare_confirmed: bool = False) -> StepResult:
        """Map one observation; with `spare_confirmed` no track is missed, and no confirmed one pruned."""
        frame, surface, lifted = observation.frame, observation.surface, observation.lifted
        with stage("integrate"):
            changed_blocks = self.voxels.integrate(frame, surface)
        with stage("associate"):
            overlap = LabelOverlap.gather(self.voxels, surface.cells, lifted)
            novelty = self._novelty.of(frame.pose)
            decisions = self.tracker.update(lifted.detections, overlap, frame.index, novelty, spare_confirmed)
            found = surface.cells, lifted.detections, decisions
            self.parts.update(PartFrame(frame.index, *found, overlap, novelty, spare_confirmed))
        with stage("vote"):
            owners = np.array([decision.track_id for decision in decisions], np.int32)
            self.voxels.admit(self.tracker.newest_id)
            spared = {decision.detection: decision.spares for decision in decisions if decision.spares}
            ids = self._vote(surface, lifted.detections, owners, spared)
        with stage("maintain"):
            if self._support_pruning:
                self._support_pruning.count_frame(surface, self._boxes, set(owners.tolist()))
            fused, pruned = self._maintain(surface, spare_confirmed)
        return StepResult(
            frame_index=frame.index,
            id_image=_enlarged(ids, surface.stride, frame.depth.shape),
            detections=lifted.detections,
            decisions=tuple(decisions),
            fused=tuple(fused),
            pruned=tuple(pruned),
            changed_blocks=changed_blocks,
        )

    def _vote(
        self,
        surface: ObservedSurface,
        detections: Sequence[Detection],
        owners: Int32Array,
        spared: Mapping[int, Sequence[int]],
    ) -> Int32Array:
        """Let voxels vote for the owners (N,) of N detections; returns the strided id image."""
        if self.config.maintenance.label_votes == "box":
            return vote_in_boxes(self.voxels, surface, detections, owners, self._boxes)
        return vote(self.voxels, surface, detections, owners, self.config.maintenance.withdraw_votes, spared)

    @property
    def _boxes(self) -> dict[int, OrientedBox]:
        """Those of the live tracks by id."""
        return {track_id: track.box for track_id, track in self.tracker.tracks.items()}

    def _maintain(self, surface: ObservedSurface, spare_confirmed: bool) -> tuple[list[tuple[int, int]], list[int]]:
        self._n_frames += 1
        self._note_meetings(surface)
        carve_every = self.config.voxels.carve_every
        # Halfway between two clean-ups, so that no frame bears both.
        if carve_every and (self._n_frames + carve_every // 2) % carve_every == 0:
            carve(self.voxels, surface)
        if self._n_frames % self.config.maintenance.interval_frames:
            return [], []
        return self._clean_up(spare_confirmed)

    def _clean_up(self, spare_confirmed: bool) -> tuple[list[tuple[int, int]], list[int]]:
        """Fuse duplicates, renew the boxes from the voxels, and prune; returns pairs (gone, survivor), and the ids of
        pruned tracks."""
        fused = [*self.tracker.fuse_stuff(sorted(self._meeting)), *self.tracker.fuse_duplicates()]
        self._meeting.clear()
        for pair in fused:
            self.replace(*pair)
        self.refresh_tracks(grown={survivor for _, survivor in fused})
        pruned = self._prune(spare_confirmed)
        for gone in pruned:
            self.replace(gone, 0)
        self.parts.prune()
        self.tracker.detected.clear()
        return fused, pruned

    def replace(self, gone: int, survivor: int) -> None:
        """The voxels and parts of a track are another's from now on; survivor 0 forgets them."""
        self.voxels.replace(gone, survivor)
        self.parts.replace(gone, survivor)

    def _note_meetings(self, surface: ObservedSurface) -> None:
        """Remember which stuff tracks of one class meet in this frame."""
        stuff = {track.id: track.class_name for track in self.tracker.tracks.values() if track.is_stuff}
        if len(stuff) > len({*stuff.values()}):
            labels = np.array(self.voxels.labels_at(surface.cells).tolist(), np.int32)
            in_view = {track_id: stuff[track_id] for track_id in np.unique(labels).tolist() if track_id in stuff}
            self._meeting |= {*meeting_pairs(surface.cells.coordinates, labels, in_view)}

    def _prune(self, spare_confirmed: bool) -> list[int]:
        if self._support_pruning is None:
            return self.tracker.prune(spare_confirmed=spare_confirmed)
        tracks = self.tracker.tracks
        confidences = {track_id: track.bank.peak_confidence for track_id, track in tracks.items()}
        doomed = self._support_pruning.doomed(support_ratios(self.voxels, self._boxes), confidences)
        return self.tracker.drop([i for i in doomed if not (spare_confirmed and tracks[i].confirmed)])

    def refresh_tracks(self, grown: Set[int] = frozenset()) -> None:
        """Renew the boxes and won shares of tracks whose voxels may have changed; `grown` are tracks that were given
        others' voxels."""
        changed = self._surface.renew(self.voxels)
        stale = [
            track
            for track in self.tracker.tracks.values()
            if changed is None or track.id in changed or track.id in grown or track.id in self.tracker.detected
        ]
        for start in range(0, len(stale), TRACKS_AT_ONCE):
            self._refresh(stale[start : start + TRACKS_AT_ONCE])

    def _refresh(self, tracks: Sequence[Track]) -> None:
        ids = [track.id for track in tracks]
        surface = self._surface.around(ids)
        points = points_by_instance(self.voxels, surface, ids)
        shares = won_shares(self.voxels, surface)
        for track in tracks:
            track.refresh(points[track.id])
            track.won_share = shares.get(track.id, 0.0)
            self.tracker.refreshed(track)

    def finish(self, *, spare_confirmed: bool = False) -> None:
        """A last pass over the tracks; after it only instances are left, labels are settled and boxes are fresh."""
        self._clean_up(spare_confirmed)
        for pair in (fused := self.tracker.fuse_parts(self.parts.tracked_parts())):
            self.replace(*pair)
        self.refresh_tracks(grown={survivor for _, survivor in fused})
        for gone in self.tracker.drop_unconfirmed():
            self.replace(gone, 0)
        self.voxels.settle()
        self.refresh_tracks()


def _enlarged(ids: Int32Array, stride: int, shape: tuple[int, ...]) -> Int32Array:
    return ids.repeat(stride, axis=0).repeat(stride, axis=1)[: shape[0], : shape[1]]
