"""Perception of one frame without the map: surface, masks and detections. A pure function of the frame, so that the
next frame can be perceived while this one is being mapped."""

from __future__ import annotations

from dataclasses import dataclass

from razer.config import MapperConfig
from razer.detection.lifting import Lifted, filter_masks, lift
from razer.detection.observed_surface import ObservedSurface
from razer.frame import Frame
from razer.models import Embedder, Segmenter
from razer.stages import stage


@dataclass(frozen=True)
class Observation:
    """A posed frame, the surface its depth shows, and what its masks were lifted to."""

    frame: Frame
    surface: ObservedSurface
    lifted: Lifted


class Perception:
    """The 2D models and the lifting (RAZER sections IV-B and IV-E)."""

    def __init__(self, config: MapperConfig, segmenter: Segmenter, embedder: Embedder) -> None:
        self.config = config
        self.segmenter = segmenter
        self.embedder = embedder

    def observe(self, frame: Frame) -> Observation:
        """Perceive one posed frame; raises UnusableFrame if it has no pose or no depth in range."""
        settings = self.config.voxels
        with stage("lift"):
            surface = ObservedSurface.of(frame, settings.voxel_size_m, settings.depth_min_m, settings.depth_max_m)
        with stage("segment"):
            masks = filter_masks(frame, self.segmenter.segment(frame), self.config.masks)
        with stage("embed"):
            embeddings = self.embedder.embed(frame, masks)
        with stage("lift"):
            lifted = lift(surface, masks, embeddings, self.config.lifting, self.config.masks.shrink_pixels)
        return Observation(frame, surface.prepared(settings.truncation_m), lifted)
