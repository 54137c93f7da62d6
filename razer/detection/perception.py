"""Perception of one frame without the map: surface, masks and detections. A pure function of the frame, so that the
next frame can be perceived while this one is being mapped."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from razer.config import MapperConfig
from razer.detection.lifting import Lifted, filter_masks, lift
from razer.detection.observed_surface import ObservedSurface
from razer.frame import Frame, Masks
from razer.models import Embedder, Segmenter
from razer.models.recorded_view import masks_of, vectors_of
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
            masks = filter_masks(frame, _where_colored(frame, masks_of(self.segmenter, frame)), self.config.masks)
            masks = in_order_of_content(masks)
        with stage("embed"):
            embeddings = vectors_of(self.embedder, frame, masks)
        with stage("lift"):
            lifted = lift(surface, masks, embeddings, self.config.lifting, self.config.masks.shrink_pixels)
        mapped = replace(frame, recorded_color=None)  # nothing looks at it any more, and frames wait in queues
        return Observation(mapped, surface.prepared(settings.truncation_m), lifted)


def in_order_of_content(masks: Masks) -> Masks:
    """The masks by area, the largest first, then by place and score: ids are given and ties are broken in their order,
    which must not be that in which a model happens to list them."""
    if len(masks) < 2:
        return masks
    flat = masks.masks.reshape(len(masks), -1)
    last = flat.shape[1] - flat[:, ::-1].argmax(axis=1)
    return masks.select(np.lexsort((masks.scores, last, flat.argmax(axis=1), -np.count_nonzero(flat, axis=1))))


def _where_colored(frame: Frame, masks: Masks) -> Masks:
    """The masks without pixels that the colour camera did not see: what a model says of them is a guess."""
    if frame.has_color is None:
        return masks
    return replace(masks, masks=masks.masks & frame.has_color)
