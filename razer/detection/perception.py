"""Perception of one frame without the map: surface, masks and detections. A pure function of the frame, so that the
next frame can be perceived while this one is being mapped."""

from __future__ import annotations

from dataclasses import dataclass, replace

from razer.config import MapperConfig
from razer.detection.lifting import Lifted, filter_masks, lift
from razer.detection.observed_surface import ObservedSurface
from razer.frame import Frame, Masks
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
            masks = filter_masks(frame, _where_colored(frame, self.segmenter.segment(frame)), self.config.masks)
        with stage("embed"):
            embeddings = self.embedder.embed(frame, masks)
        with stage("lift"):
            lifted = lift(surface, masks, embeddings, self.config.lifting, self.config.masks.shrink_pixels)
        return Observation(frame, surface.prepared(settings.truncation_m), lifted)


def _where_colored(frame: Frame, masks: Masks) -> Masks:
    """The masks without pixels that the colour camera did not see: what a model says of them is a guess."""
    if frame.has_color is None:
        return masks
    return replace(masks, masks=masks.masks & frame.has_color)
