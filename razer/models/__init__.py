"""2D models behind two protocols: what finds masks, and what describes them by vectors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from razer.frame import Frame, Masks
from razer.plugins import load

SEGMENTERS = {
    "geometric": "razer.models.geometric:GeometricSegmenter",
    "oracle": "razer.models.oracle:OracleSegmenter",
    "masks": "razer.models.masks_on_disk:MasksOnDisk",
}
EMBEDDERS = {
    "appearance": "razer.models.appearance:AppearanceEmbedder",
    "oracle": "razer.models.oracle:OracleEmbedder",
}


class Segmenter(Protocol):
    """The paper's F, first half: M_t = F(I_t) (eq. 2)."""

    def segment(self, frame: Frame) -> Masks:
        """The masks found in one frame; may be none."""


class Embedder(Protocol):
    """The paper's F, second half: a vector for each mask (eq. 11)."""

    def embed(self, frame: Frame, masks: Masks) -> NDArray[np.float32]:
        """Vectors of unit length, (N, D) float32, one for each of the N masks."""


def make_segmenter(name: str, options: Mapping[str, Any]) -> Segmenter:
    """The segmenter called `name` (see SEGMENTERS) or "module:Class"; raises BadInput."""
    segmenter: Segmenter = load("segmenter", name, SEGMENTERS, options)
    return segmenter


def make_embedder(name: str, options: Mapping[str, Any]) -> Embedder:
    """The embedder called `name` (see EMBEDDERS) or "module:Class"; raises BadInput."""
    embedder: Embedder = load("embedder", name, EMBEDDERS, options)
    return embedder
