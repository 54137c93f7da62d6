"""One frame through the method, and the map it leaves (section III-F)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from razer.carving import carve
from razer.cells import ObservedSurface
from razer.config import MapperConfig
from razer.duplicates import Sightings, mapped_twice
from razer.evidence import LabelEvidence
from razer.frame import Frame
from razer.lifting import Detection
from razer.models import Embedder, Segmenter
from razer.panoptic_map import PanopticMap
from razer.perception import Observation, Perception
from razer.rebuild import Follower, Pose
from razer.stages import stage
from razer.step import Decision, Step
from razer.support import support_ratios
from razer.surface import extract_mesh, points_at
from razer.track import Track
from razer.tracker import Tracker
from razer.voting import vote
from razer.voxels import VoxelMap


class Mapper:
    """Posed frames in, a panoptic map out; at any frame the map is complete for what was seen."""

    def __init__(
        self, config: MapperConfig, segmenter: Segmenter, embedder: Embedder, *, device: str = "CPU:0"
    ) -> None:
        self.config = config
        self.perception = Perception(config, segmenter, embedder)
        self.voxels = VoxelMap(config.voxels, device)
        self.tracker = Tracker(config)
        self.follower = Follower(config) if config.follow.enabled else None
        self._frames = 0
        self._last_index = 0

    @property
    def tracks(self) -> list[Track]:
        """The live tracks, confirmed and tentative, by id."""
        return list(self.tracker.tracks.values())

    def step(self, frame: Frame) -> Step:
        """Perceive and map one posed frame; raises UnusableFrame before anything changed."""
        return self.fuse(self.perception.observe(frame))

    def fuse(self, seen: Observation) -> Step:
        """Map what was perceived of one frame."""
        frame, surface, lifted = seen.frame, seen.surface, seen.lifted
        with stage("integrate"):
            changed_blocks = self.voxels.integrate(frame, surface)
        with stage("associate"):
            evidence = LabelEvidence.gather(self.voxels, surface.cells, lifted)
            decisions = self.tracker.update(lifted.detections, evidence, frame.index)
        with stage("vote"):
            ids = self._vote(surface, lifted.detections, decisions)
        with stage("maintain"):
            fused, pruned = self._maintain(surface, frame.index)
        before = self.voxels
        fused += self._follow(seen, ids)
        return Step(
            frame_index=frame.index,
            id_image=_enlarged(ids, surface.stride, frame.depth.shape),
            detections=lifted.detections,
            decisions=tuple(decisions),
            fused=tuple(fused),
            pruned=tuple(pruned),
            changed_blocks=changed_blocks,
            rebuilt=self.voxels is not before,
        )

    def move(self, corrections: Mapping[int, Pose]) -> None:
        """Note new world_from_camera (4, 4) of past frames, by frame index; the map follows as the run goes on, and
        when it finishes. Raises ValueError unless `follow.enabled` is set."""
        if self.follower is None:
            raise ValueError("poses were corrected, but follow.enabled is off and no frames were kept")
        self.follower.move(corrections)

    def _follow(self, seen: Observation, ids: NDArray[np.int32]) -> list[tuple[int, int]]:
        """Keep the frame and rebuild a little where poses were corrected; returns duplicates that this brought to
        light, (gone, survivor)."""
        if self.follower is None:
            return []
        with stage("rebuild"):
            self.follower.keep(seen.frame, seen.surface, ids)
            rebuilt = self.follower.advance(self.voxels)
            return [] if rebuilt is None else self._adopt(rebuilt, self.follower.sightings)

    def _adopt(self, rebuilt: VoxelMap, sightings: Sightings) -> list[tuple[int, int]]:
        """Go on with a rebuilt volume: what was mapped twice is fused, boxes are renewed, misses are forgiven."""
        self.voxels = rebuilt
        fused = []
        least = self.config.follow.fuse_shared_votes
        while duplicates := self.tracker.fuse_alike(mapped_twice(self.voxels, sightings, least)):
            for gone, survivor in duplicates:
                self.voxels.replace(gone, survivor)
            fused += duplicates
        for track in self.tracks:
            track.misses = 0
        self._refresh_tracks()
        return fused

    def catch_up(self) -> Iterator[float]:
        """Rebuild the map from all kept frames if their poses were corrected since; yields the share done, after
        each frame. `finish` does the same in one go."""
        if self.follower is None:
            return
        for done, rebuilt in self.follower.replay_all(self.voxels):
            if rebuilt is not None:
                with stage("rebuild"):
                    self._adopt(rebuilt, self.follower.sightings)
            yield done

    def _vote(
        self, surface: ObservedSurface, detections: tuple[Detection, ...], decisions: list[Decision]
    ) -> NDArray[np.int32]:
        """Each voxel at the observed surface takes one vote for the track that owns the pixel it projects to;
        returns the strided id image."""
        ids = np.zeros(surface.depth.shape, np.int32)
        # Small things stand on or before large ones: they are painted last.
        for decision in sorted(decisions, key=lambda d: -len(detections[d.detection].pixels)):
            pixels = detections[decision.detection].pixels
            ids[surface.rows[pixels], surface.columns[pixels]] = decision.track_id
        self.voxels.admit(self.tracker.newest_id)
        vote(self.voxels, surface, ids)
        return ids

    def _maintain(self, surface: ObservedSurface, frame_index: int) -> tuple[list[tuple[int, int]], list[int]]:
        self._frames += 1
        self._last_index = frame_index
        carve_every = self.config.voxels.carve_every
        # Halfway between two clean-ups, so that no frame bears both.
        if carve_every and (self._frames + carve_every // 2) % carve_every == 0:
            carve(self.voxels, surface)
        if self._frames % self.config.maintenance.every:
            return [], []
        return self._clean_up()

    def _clean_up(self) -> tuple[list[tuple[int, int]], list[int]]:
        """Fuse duplicates, renew the boxes from the voxels, and prune."""
        fused = self.tracker.fuse_duplicates()
        for gone, survivor in fused:
            self.voxels.replace(gone, survivor)
        self._refresh_tracks()
        # Where the map lies beside the poses, things are missed that are not gone.
        behind = self.follower is not None and self.follower.is_behind
        pruned = self.tracker.prune(self._last_index, spare_confirmed=behind)
        for gone in pruned:
            self.voxels.replace(gone, 0)
        return fused, pruned

    def _refresh_tracks(self) -> None:
        surface = self.voxels.surface_addresses()
        points = points_at(self.voxels, surface)
        order = np.argsort(points.instances, kind="stable")
        bounds = np.searchsorted(points.instances[order], [[t.id, t.id + 1] for t in self.tracks] or [[0, 0]])
        support = support_ratios(self.voxels, surface)
        for track, (start, end) in zip(self.tracks, bounds, strict=False):
            track.refresh(points.positions[order[start:end]].astype(np.float64))
            track.support = support.get(track.id, 0.0)
            self.tracker.refreshed(track)

    def finish(self) -> None:
        """Catch up with corrected poses, and a last pass over the tracks; after it labels are settled and boxes are
        fresh."""
        for _ in self.catch_up():
            pass
        self._clean_up()
        for gone in self.tracker.drop_unconfirmed():
            self.voxels.replace(gone, 0)
        self.voxels.settle()
        self._refresh_tracks()

    def snapshot(self) -> PanopticMap:
        """The map as it is now: confirmed instances and the labelled mesh."""
        return PanopticMap.of([t for t in self.tracks if t.confirmed], extract_mesh(self.voxels))


def _enlarged(ids: NDArray[np.int32], stride: int, shape: tuple[int, ...]) -> NDArray[np.int32]:
    return ids.repeat(stride, axis=0).repeat(stride, axis=1)[: shape[0], : shape[1]]
