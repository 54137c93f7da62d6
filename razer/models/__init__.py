"""2D models behind two protocols: segmenters, which make masks, and embedders, which make a vector for each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

from razer.arrays import BoolArray, Float32Array, Uint8Array
from razer.frame import Frame, Masks
from razer.plugins import EmbedderSettings, Trust, load

SEGMENTERS = {
    "geometric": "razer.models.geometric.segmenter:GeometricSegmenter",
    "oracle": "razer.models.oracle.segmenter:OracleSegmenter",
    "masks": "razer.models.stored_masks:StoredMasks",
    "panoptic": "razer.models.panoptic:PanopticSegmenter",
    "prompted": "razer.models.text_prompted.segmenter:PromptedSegmenter",
    "rfdetr": "razer.models.rfdetr.segmenter:RfDetrSegmenter",
    "sam": "razer.models.sam.segmenter:SamSegmenter",
    "semantic": "razer.models.semantic.segmenter:SemanticSegmenter",
    "yolo": "razer.models.yolo.segmenter:YoloSegmenter",
}
COMBINED = "razer.models.combined.segmenter:CombinedSegmenter"  # names joined by "+"
EMBEDDERS = {
    "appearance": "razer.models.appearance:AppearanceEmbedder",
    "clip": "razer.models.clip.embedder:ClipEmbedder",
    "names": "razer.models.name_vectors.embedder:NamesEmbedder",
    "oracle": "razer.models.oracle.embedder:OracleEmbedder",
}


class Segmenter(Protocol):
    """The paper's F, first half: M_t = F(I_t) (RAZER eq. 2)."""

    def segment(self, frame: Frame) -> Masks:
        """The masks of one frame; may be none."""


class Embedder(Protocol):
    """The paper's F, second half: a vector for each mask (RAZER eq. 12)."""

    def embed(self, frame: Frame, masks: Masks) -> Float32Array:
        """Vectors of unit length, (N, D) float32, one for each of the N masks."""


@runtime_checkable
class TextEncoder(Protocol):
    """An embedder whose vectors can be queried by text: the paper's phi_text (RAZER section IV-I)."""

    def embed_texts(self, texts: Sequence[str]) -> Float32Array:
        """Vectors of unit length, (N, D) float32, in the space of `embed`; each text is embedded as it stands."""


@runtime_checkable
class NameTable(TextEncoder, Protocol):
    """A text encoder that knows names and no sentences, and so is queried without prompt templates."""

    @property
    def known_names(self) -> Sequence[str]:
        """The names it knows, synonyms left out; none where it takes any name."""


@runtime_checkable
class ImageEncoder(Protocol):
    """An embedder whose vectors can be queried by an image (RAZER section IV-I)."""

    def embed_region(self, rgb: Uint8Array, mask: BoolArray) -> Float32Array:
        """Vector of unit length, (D,) float32, in the space of `embed`, of what a mask (H, W) covers in an image
        (H, W, 3)."""


def make_segmenter(name: str, options: Mapping[str, Any] | None = None, trust: Trust | None = None) -> Segmenter:
    """The segmenter called `name` (see SEGMENTERS), a trusted "module:Class", or several, joined by "+"; raises
    BadInput."""
    table, options = SEGMENTERS, dict(options or {})
    if "+" in name:
        table, options = {**SEGMENTERS, name: COMBINED}, {**options, "parts": name}
    segmenter: Segmenter = load("segmenter", name, table, options, methods=["segment"], trust=trust)
    return segmenter


def make_embedder(name: str, options: Mapping[str, Any] | None = None, trust: Trust | None = None) -> Embedder:
    """The embedder called `name` (see EMBEDDERS), or a trusted "module:Class"; raises BadInput."""
    embedder: Embedder = load("embedder", name, EMBEDDERS, options or {}, methods=["embed"], trust=trust)
    return embedder


def embedder_of(settings: EmbedderSettings) -> Embedder:
    """The embedder that settings name, as far as they are trusted; raises BadInput."""
    return make_embedder(settings.name, settings.options, settings.trust)


def unrelated_cosine(embedder: Embedder) -> float:
    """The cosine that vectors of unlike objects have in the embedder's space: its `unrelated_cosine`, else 0."""
    return float(getattr(embedder, "unrelated_cosine", 0.0))


def tells_instances(segmenter: Segmenter) -> bool:
    """Whether each mask of a thing is one thing, with its own border; not where masks are pieces of a class map, be it
    in one part of a combination."""
    return bool(getattr(segmenter, "tells_instances", True))


def prefers_fused_surface(segmenter: Segmenter) -> bool:
    """Whether the surface of the finished map shows a segmenter what single frames do not: its `prefers_fused_surface`,
    else no."""
    return bool(getattr(segmenter, "prefers_fused_surface", False))
