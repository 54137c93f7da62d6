"""One frame through the method, and the map it leaves (section III-F)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from copy import copy
from dataclasses import replace

import numpy as np
import torch

from razer.arrays import Int32Array, Pose
from razer.config import MapperConfig
from razer.detection.observed_surface import ObservedSurface
from razer.detection.perception import Observation, Perception
from razer.frame import Frame
from razer.models import Embedder, Segmenter, unrelated_cosine
from razer.models.model_choice import choose_models
from razer.panoptic_map import PanopticMap
from razer.query.text_queries import TextQueryEncoder
from razer.reintegration.id_matching import majority_ids, match_ids
from razer.reintegration.reintegrator import Apply, Reintegrator
from razer.semantics.gravity import up_direction
from razer.stages import stage
from razer.storage.settings_list import list_settings
from razer.storage.toml_text import toml_text
from razer.tracking.duplicates import find_duplicates
from razer.tracking.label_overlap import LabelOverlap
from razer.tracking.step_result import StepResult
from razer.tracking.track import Track
from razer.tracking.tracker import Tracker
from razer.volume.label_voting import vote
from razer.volume.mesh_extraction import extract_mesh
from razer.volume.space_carving import carve
from razer.volume.support import support_ratios
from razer.volume.surface_cache import SurfaceCache, points_by_instance
from razer.volume.voxel_map import VoxelMap


class Mapper:
    """Posed frames in, a panoptic map out; at any frame the map is complete for what was seen."""

    def __init__(
        self,
        config: MapperConfig | None = None,
        segmenter: Segmenter | str | None = None,
        embedder: Embedder | str | None = None,
        *,
        device: str = "CPU:0",
    ) -> None:
        """Start with an empty map.

        Args:
            config: the settings; None = the defaults.
            segmenter: what finds masks, an object or a name (see `make_segmenter`); None = the one of the settings.
            embedder: what describes them by vectors, likewise.
            device: where the voxels live, such as "CUDA:0".

        Raises:
            BadInput: for a model that there is not.
        """
        config, segmenter, embedder = choose_models(config or MapperConfig(), segmenter, embedder)
        self.config = config
        self.perception = Perception(config, segmenter, embedder)
        self._words = TextQueryEncoder(embedder)
        self.voxels = VoxelMap(config.voxels, device)
        self.tracker = Tracker(config, unrelated_cosine=unrelated_cosine(embedder))
        self.reintegrator = Reintegrator(config) if config.reintegration.enabled else None
        self._surface = SurfaceCache()
        self._frames = 0
        self._last_index = self._refreshed_at = 0
        self._camera_up = np.zeros(3)  # summed over frames: cameras are mostly held upright

    @property
    def tracks(self) -> list[Track]:
        """The live tracks, confirmed and tentative, by id."""
        return list(self.tracker.tracks.values())

    def step(self, frame: Frame) -> StepResult:
        """Perceive and map one posed frame; raises UnusableFrame before anything changed."""
        return self.fuse(self.perception.observe(frame))

    def fuse(self, seen: Observation) -> StepResult:
        """Map what was perceived of one frame."""
        frame, surface, lifted = seen.frame, seen.surface, seen.lifted
        self._camera_up -= frame.pose[:3, 1]
        with stage("integrate"):
            changed_blocks = self.voxels.integrate(frame, surface)
        with stage("associate"):
            evidence = LabelOverlap.gather(self.voxels, surface.cells, lifted)
            decisions = self.tracker.update(lifted.detections, evidence, frame.index)
        with stage("vote"):
            owners = np.array([decision.track_id for decision in decisions], np.int32)
            self.voxels.admit(self.tracker.newest_id)
            ids = vote(self.voxels, surface, lifted.detections, owners, self.config.maintenance.withdraw_votes)
        with stage("maintain"):
            fused, pruned = self._maintain(surface, frame.index)
        before = self.voxels
        fused += self._reintegrate(seen, owners)
        return StepResult(
            frame_index=frame.index,
            id_image=_enlarged(ids, surface.stride, frame.depth.shape),
            detections=lifted.detections,
            decisions=tuple(decisions),
            fused=tuple(fused),
            pruned=tuple(pruned),
            changed_blocks=changed_blocks,
            rebuilt=self.voxels is not before,
        )

    def move(self, corrections: Mapping[int, Pose | None]) -> None:
        """Note new world_from_camera (4, 4) of past frames, by frame index; the map follows as the run goes on, and
        when it finishes. What frames showed whose pose is None is forgotten then. Raises
        ValueError unless `reintegration.enabled` is set."""
        if self.reintegrator is None:
            raise ValueError("poses were corrected, but reintegration.enabled is off and no frames were kept")
        self.reintegrator.move(corrections)

    def _reintegrate(self, seen: Observation, owners: Int32Array) -> list[tuple[int, int]]:
        """Keep the frame and rebuild a little where poses were corrected; returns duplicates that this brought to
        light, (gone, survivor)."""
        if self.reintegrator is None:
            return []
        with stage("rebuild"):
            self.reintegrator.keep(seen, owners)
            rebuilt = self.reintegrator.advance(self.voxels)
            return [] if rebuilt is None else self._adopt(rebuilt, self.reintegrator.owners)

    def _adopt(self, rebuilt: VoxelMap, owners: Sequence[Int32Array]) -> list[tuple[int, int]]:
        """Go on with a rebuilt volume: what was mapped twice is fused, boxes are renewed, misses are forgiven."""
        self.voxels = rebuilt
        fused = []
        least = self.config.reintegration.fuse_shared_votes
        while duplicates := self.tracker.fuse_alike(find_duplicates(self.voxels, owners, least)):
            for gone, survivor in duplicates:
                self.voxels.replace(gone, survivor)
            fused += duplicates
        for track in self.tracks:
            track.misses = 0
        self._refresh_tracks()
        return fused

    def catch_up(self, apply: Apply = map) -> Iterator[float]:
        """Map all kept frames once more at their final poses if those were corrected since; yields the share done,
        after each frame. They are unpacked by `apply`. `finish` does the same in one go."""
        reintegrator = self.reintegrator
        if reintegrator is None or reintegrator.is_final:
            return
        again, owners = self._anew(reintegrator.carve_every), []
        replays = reintegrator.replays(range(reintegrator.n_kept), apply)
        for _ in range(reintegrator.n_kept):
            with stage("rebuild"):
                owners.append(again.fuse(next(replays)).owners)
                if len(owners) == reintegrator.n_kept:
                    self._inherit(again, owners, reintegrator)
            yield len(owners) / reintegrator.n_kept

    def _anew(self, carve_every: int) -> Mapper:
        """A mapper that knows nothing yet and gives new ids, for frames that were kept."""
        again = copy(self)
        voxels = self.config.voxels.model_copy(update={"carve_every": carve_every})
        again.config = self.config.model_copy(update={"voxels": voxels})
        again.voxels = self.voxels.empty_copy()
        again.tracker = Tracker(again.config, self.tracker.newest_id, self.tracker.unrelated_cosine)
        again.reintegrator = None
        again._surface = SurfaceCache()
        again._frames = 0
        return again

    def _inherit(self, again: Mapper, owners: list[Int32Array], reintegrator: Reintegrator) -> None:
        """Go on with what `again` mapped; its instances take over the ids of those they were before."""
        before, after = (self._alive(np.concatenate(ids)) for ids in (reintegrator.owners, owners))
        names = match_ids(before, after)
        again.tracker.rename(names)
        for new, old in names.items():
            again.voxels.replace(new, old)
        # Who has no heir is read as the one that most of it went to, if any.
        taken = majority_ids(before, self._alive(after))
        for gone in set(self.tracker.tracks) - set(names.values()):
            again.voxels.replace(gone, taken.get(gone, 0))
        self.tracker = again.tracker
        reintegrator.mapped_again(again.voxels, owners)
        self._adopt(again.voxels, owners)

    def _alive(self, ids: Int32Array) -> Int32Array:
        return self.voxels.resolve(torch.from_numpy(ids)).cpu().numpy()

    def _maintain(self, surface: ObservedSurface, frame_index: int) -> tuple[list[tuple[int, int]], list[int]]:
        self._frames += 1
        self._last_index = frame_index
        carve_every = self.config.voxels.carve_every
        # Halfway between two clean-ups, so that no frame bears both.
        if carve_every and (self._frames + carve_every // 2) % carve_every == 0:
            carve(self.voxels, surface)
        if self._frames % self.config.maintenance.interval_frames:
            return [], []
        return self._clean_up()

    def _clean_up(self) -> tuple[list[tuple[int, int]], list[int]]:
        """Fuse duplicates, renew the boxes from the voxels, and prune."""
        fused = self.tracker.fuse_duplicates()
        for gone, survivor in fused:
            self.voxels.replace(gone, survivor)
        self._refresh_tracks(grown={survivor for _, survivor in fused})
        # Where the map lies beside the poses, things are missed that are not gone.
        behind = self.reintegrator is not None and self.reintegrator.is_behind
        pruned = self.tracker.prune(self._last_index, spare_confirmed=behind)
        for gone in pruned:
            self.voxels.replace(gone, 0)
        return fused, pruned

    def _refresh_tracks(self, grown: Set[int] = frozenset()) -> None:
        """Renew what tracks know of their voxels, where those may have changed; `grown` are tracks that were given
        others' voxels."""
        surface, changed = self._surface.renew(self.voxels)
        since, self._refreshed_at = self._refreshed_at, self._last_index
        stale = [
            track
            for track in self.tracks
            if changed is None or track.id in changed or track.id in grown or track.last_frame >= since
        ]
        points = points_by_instance(self.voxels, surface, [track.id for track in stale])
        support = support_ratios(self.voxels, surface)
        for track in stale:
            track.refresh(points[track.id])
            track.support = support.get(track.id, 0.0)
            self.tracker.refreshed(track)

    def finish(self) -> PanopticMap:
        """Catch up with corrected poses, and a last pass over the tracks; after it labels are settled and boxes are
        fresh. The finished map."""
        for _ in self.catch_up():
            pass
        self._clean_up()
        for gone in self.tracker.drop_unconfirmed():
            self.voxels.replace(gone, 0)
        self.voxels.settle()
        self._refresh_tracks()
        return self.snapshot()

    def snapshot(self) -> PanopticMap:
        """The map as it is now: confirmed instances and the labelled mesh."""
        mesh = extract_mesh(self.voxels)
        panoptic = PanopticMap.of([t for t in self.tracks if t.confirmed], mesh, self._words)
        return replace(
            panoptic,
            up=up_direction(mesh, self._camera_up),
            config_text=toml_text(list_settings(self.config), "Settings of a map."),
            open_volume=lambda: self.voxels,
        )


def _enlarged(ids: Int32Array, stride: int, shape: tuple[int, ...]) -> Int32Array:
    return ids.repeat(stride, axis=0).repeat(stride, axis=1)[: shape[0], : shape[1]]
