"""Online panoptic mapping: posed RGB-D frames in, instances and a labelled surface out (RAZER section IV-G)."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from razer.arrays import Float64Array, Pose
from razer.config import MapperConfig
from razer.detection.perception import Observation, Perception
from razer.errors import BadInput
from razer.frame import Frame
from razer.models import Embedder, Segmenter, prefers_fused_surface, tells_instances, unrelated_cosine
from razer.models.model_choice import choose_models
from razer.panoptic_map import PanopticMap
from razer.query.text_queries import TextQueryEncoder
from razer.reintegration.kept_frames import Apply
from razer.reintegration.reintegrator import Reintegrator
from razer.semantics.gravity import up_direction
from razer.similarity.similarity_scale import SimilarityScale
from razer.stages import stage
from razer.storage.settings_list import list_settings
from razer.storage.toml_text import toml_text
from razer.surface_segmentation.segmented_map import segmented_map
from razer.surface_segmentation.structure_claims import with_claimed_structure
from razer.tracking.panoptic_integrator import PanopticIntegrator
from razer.tracking.parts.part_surface import part_surfaces
from razer.tracking.step_result import StepResult
from razer.tracking.track import Track
from razer.tracking.tracker import Tracker
from razer.volume.mesh_extraction import extract_mesh
from razer.volume.voxel_map import VoxelMap


@dataclass(frozen=True)
class MapperState:
    """All that a `Mapper` has learnt from its frames, as it goes on changing: the volume with its tracks, the frames
    kept to be fused anew, how many frames were mapped, and the sum (3,) of their cameras' upward directions."""

    integrator: PanopticIntegrator
    reintegrator: Reintegrator | None
    n_frames: int
    camera_up: Float64Array


class Mapper:
    """Posed frames in, a panoptic map out; after any frame the map is complete for what was observed."""

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
        self._text_queries = TextQueryEncoder(embedder)
        tracker = Tracker(config, scale=SimilarityScale(unrelated_cosine(embedder)))
        self._integrator = PanopticIntegrator(config, VoxelMap(config.voxels, device), tracker)
        self.reintegrator = Reintegrator(config) if config.reintegration.enabled else None
        self._n_frames = 0
        self._camera_up = np.zeros(3)  # summed over frames: cameras are mostly held upright

    @property
    def state(self) -> MapperState:
        """What it has learnt so far."""
        return MapperState(self._integrator, self.reintegrator, self._n_frames, self._camera_up)

    @state.setter
    def state(self, state: MapperState) -> None:
        """Go on from the state of another that had the same settings and models."""
        self._integrator, self.reintegrator = state.integrator, state.reintegrator
        self._n_frames, self._camera_up = state.n_frames, state.camera_up

    @property
    def voxels(self) -> VoxelMap:
        """The volume as it is now; corrected poses replace it by another."""
        return self._integrator.voxels

    @property
    def tracker(self) -> Tracker:
        """The live tracks with their spatial index."""
        return self._integrator.tracker

    @property
    def tracks(self) -> list[Track]:
        """The live tracks, confirmed and tentative, by id."""
        return list(self.tracker.tracks.values())

    def step(self, frame: Frame) -> StepResult:
        """Perceive and map one posed frame; raises UnusableFrame before anything changed."""
        return self.fuse(self.perception.observe(frame))

    def fuse(self, observation: Observation) -> StepResult:
        """Map what was perceived of one frame: integrate its depth, associate its detections with tracks, vote for
        labels, maintain the tracks, and reintegrate a few earlier frames where poses were corrected."""
        step = self._integrator.fuse(observation, spare_confirmed=self._is_behind)
        self._camera_up -= observation.frame.pose[:3, 1]
        self._n_frames += 1
        if self.reintegrator is None:
            return step
        with stage("rebuild"):
            self.reintegrator.keep(observation, step.owners)
            fused = self.reintegrator.advance(self._integrator)
        return step if fused is None else replace(step, fused=(*step.fused, *fused), rebuilt=True)

    def move(self, corrections: Mapping[int, Pose | None]) -> None:
        """Note new world_from_camera (4, 4) of past frames, by frame index; the map follows as the run goes on, and
        when it finishes. What frames showed whose pose is None is forgotten then. Raises
        ValueError unless `reintegration.enabled` is set."""
        if self.reintegrator is None:
            raise ValueError("poses were corrected, but reintegration.enabled is off and no frames were kept")
        self.reintegrator.move(corrections)

    def weigh(self, weights: Mapping[int, float]) -> None:
        """Note how much frames count in the map, above 0 and below 1, by frame index; all others count in full. The map
        follows when it finishes, where `reintegration.enabled` is set."""
        if self.reintegrator is not None:
            self.reintegrator.weigh(weights)

    def catch_up(self, apply: Apply = map) -> Generator[float]:
        """Map all kept frames once more at their final poses if those were corrected since; yields the share done,
        after each frame. They are unpacked by `apply`. `finish` does the same in one go."""
        if self.reintegrator is not None:
            yield from self.reintegrator.catch_up(self._integrator, apply)

    def finish(self, *, catch_up: bool = True) -> PanopticMap:
        """Catch up with corrected poses, unless there is no time, and a last pass over the tracks; after it labels are
        settled and boxes are fresh. The finished map; where `surface_segmentation` says so, its instances are segments
        of its surface, or its planes of structure belong to the stuff that has most of them."""
        if catch_up:
            for _ in self.catch_up():
                pass
        self._integrator.finish(spare_confirmed=self._is_behind)
        panoptic, settings = self.snapshot(), self.config.surface_segmentation
        segmenter, voxel_size_m = self.perception.segmenter, self.config.voxels.voxel_size_m
        if settings.use == "always" or (settings.use == "auto" and prefers_fused_surface(segmenter)):
            return segmented_map(panoptic, settings, voxel_size_m=voxel_size_m, newest_id=self.tracker.newest_id)
        if settings.structure == "always" or (settings.structure == "auto" and not tells_instances(segmenter)):
            return with_claimed_structure(panoptic, settings, voxel_size_m=voxel_size_m)
        return panoptic

    @property
    def _is_behind(self) -> bool:
        """Whether the map lies beside the poses, where surface that a frame does not confirm need not be gone."""
        return self.reintegrator is not None and self.reintegrator.is_behind

    def snapshot(self) -> PanopticMap:
        """The map as it is now: confirmed instances, their parts and the labelled mesh."""
        mesh = extract_mesh(self.voxels)
        up = up_direction(mesh, self._camera_up)
        confirmed = {track.id: track for track in self.tracks if track.confirmed}
        parts = {whole: parts for whole, parts in self._integrator.parts.parts.items() if whole in confirmed}
        surfaces = part_surfaces(parts, mesh.vertices, mesh.instances, self.config)
        size_m = self.config.voxels.voxel_size_m
        panoptic = PanopticMap.of([*confirmed.values()], mesh, self._text_queries, surfaces, size_m)
        return replace(
            panoptic.in_parts() if self.config.granularity == "part" else panoptic,
            up=up if up.any() else None,
            config_text=toml_text(list_settings(self.config), "Settings of a map."),
            open_volume=partial(self._volume_of, self._n_frames),
        )

    def _volume_of(self, n_frames: int) -> VoxelMap:
        """The volume of a snapshot that was taken after so many frames: it is not copied, and goes on changing."""
        if n_frames != self._n_frames:
            raise BadInput("frames were mapped since this snapshot was taken: take another, or save it at once")
        return self.voxels
