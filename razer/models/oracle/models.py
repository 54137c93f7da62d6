"""Models that know the truth, and err as much as they are told: they separate the map's faults from a model's."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from scipy import ndimage

from razer.arrays import BoolArray, Float32Array, Float64Array, Int32Array
from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models.oracle.mask_noise import FULL_NOISE, MaskNoise

UNKNOWN = "unknown"
_FULL_COSINE = 0.7
_FULL_WRONG_CLASS = 0.1


class OracleSegmenter:
    """Masks from a frame's own instance ids, with class names and score 1.

    noise "full" drops 15 % of the masks, splits 10 %, merges 5 % and moves borders by up to 3 px; every part can
    be set by itself (see MaskNoise), also hold=10, which keeps a dropped mask away for ten frames. Raises
    BadInput."""

    def __init__(
        self,
        noise: Literal["none", "full"] = "none",
        seed: int = 0,
        *,
        drop: float | None = None,
        hold: int | None = None,
        split: float | None = None,
        split_frames: int | None = None,
        merge: float | None = None,
        jitter_px: int | None = None,
    ) -> None:
        _check_preset(noise)
        given: dict[str, Any] = {
            "drop": drop,
            "hold": hold,
            "split": split,
            "split_frames": split_frames,
            "merge": merge,
            "jitter_px": jitter_px,
        }
        preset = FULL_NOISE if noise == "full" else MaskNoise()
        self.noise = replace(preset, seed=seed, **{k: v for k, v in given.items() if v is not None})

    def segment(self, frame: Frame) -> Masks:
        """The masks of one frame; raises BadInput when the frame has no instance ids."""
        if frame.instance_ids is None:
            raise BadInput(
                f"frame {frame.index} has no instance ids, which the oracle segmenter needs: "
                "use a recording with ids/, or --segmenter geometric"
            )
        found = list(self._masks(frame.index, frame.instance_ids))
        if not found:
            return Masks.none(*frame.instance_ids.shape)
        masks = np.zeros((len(found), *frame.instance_ids.shape), np.bool_)
        for canvas, (_, window, mask) in zip(masks, found, strict=True):
            canvas[window] = mask
        names = tuple(frame.instance_classes.get(instance, UNKNOWN) for instance, _, _ in found)
        return Masks(masks, np.ones(len(found), np.float32), names)

    def _masks(self, index: int, ids: Int32Array) -> Iterator[tuple[int, tuple[slice, slice], BoolArray]]:
        """Instance, window of the image and mask within the window, in order of instance."""
        boxes = {i: box for i, box in enumerate(ndimage.find_objects(ids.clip(0)), start=1) if box is not None}
        kept = [i for i in boxes if self.noise.keeps(index, i)]
        swallowed = self.noise.merged(index, ids, kept)
        for instance in kept:
            if instance in swallowed:
                continue
            members = [instance, *(prey for prey, eater in swallowed.items() if eater == instance)]
            window = _window([boxes[m] for m in members], self.noise.jitter_px, ids.shape)
            mask = np.isin(ids[window], members) if len(members) > 1 else ids[window] == instance
            for part, piece in enumerate(self.noise.pieces(index, instance, mask)):
                frayed = self.noise.frayed(index, instance, part, piece)
                if frayed.any():
                    yield instance, window, frayed


class OracleEmbedder:
    """One unit vector for each class name, the same for the same seed, blurred to a given cosine.

    noise "full" means cosine 0.7 to the class's vector and 10 % vectors of another class of the recording.
    Needs masks with class names. Raises BadInput."""

    def __init__(
        self,
        noise: Literal["none", "full"] = "none",
        seed: int = 0,
        *,
        dimension: int = 64,
        cosine: float | None = None,
        wrong_class: float | None = None,
    ) -> None:
        _check_preset(noise)
        full = noise == "full"
        self.seed, self.dimension = seed, dimension
        self.cosine = cosine if cosine is not None else (_FULL_COSINE if full else 1.0)
        self.wrong_class = wrong_class if wrong_class is not None else (_FULL_WRONG_CLASS if full else 0.0)
        if dimension < 2 or not 0 <= self.cosine <= 1 or not 0 <= self.wrong_class <= 1:
            raise BadInput("the oracle embedder takes dimension >= 2 and cosine and wrong_class from 0 to 1")

    def class_vector(self, name: str) -> Float64Array:
        """The unit vector (dimension,) of a class."""
        vector = np.random.default_rng([self.seed, *_digest(name)]).standard_normal(self.dimension)
        return vector / np.linalg.norm(vector)

    @property
    def known_names(self) -> tuple[str, ...]:
        """None in particular: any name has its vector."""
        return ()

    def embed_texts(self, texts: Sequence[str]) -> Float32Array:
        """The vectors (N, dimension) of class names."""
        return np.stack([self.class_vector(name) for name in texts]).astype(np.float32)

    def embed(self, frame: Frame, masks: Masks) -> Float32Array:
        """A unit vector for each mask, (N, dimension) float32; raises BadInput for masks without class names."""
        if not len(masks):
            return np.zeros((0, self.dimension), np.float32)
        if masks.class_names is None:
            raise BadInput("the oracle embedder needs masks with class names: use it with --segmenter oracle")
        others = sorted({*frame.instance_classes.values(), *masks.class_names})
        vectors = np.zeros((len(masks), self.dimension), np.float32)
        for number, (name, mask) in enumerate(zip(masks.class_names, masks.masks, strict=True)):
            # Which masks reach the embedder, and in which order, depends on filters: the mask itself is the key.
            key = [self.seed, frame.index, int(mask.argmax()), int(np.count_nonzero(mask)), *_digest(name)]
            vectors[number] = self._blurred(self._said(name, others, rng := np.random.default_rng(key)), rng)
        return vectors

    def _said(self, name: str, names: list[str], rng: np.random.Generator) -> str:
        """The class name, or now and then another one."""
        wrong = [other for other in names if other != name]
        return wrong[rng.integers(len(wrong))] if rng.random() < self.wrong_class and wrong else name

    def _blurred(self, name: str, rng: np.random.Generator) -> Float64Array:
        vector = self.class_vector(name)
        aside = rng.standard_normal(self.dimension)
        aside -= (aside @ vector) * vector
        aside /= np.linalg.norm(aside)
        return self.cosine * vector + np.sqrt(1 - self.cosine**2) * aside


def _check_preset(noise: str) -> None:
    if noise not in ("none", "full"):
        raise BadInput(f"noise is none or full, not '{noise}'")


def _digest(name: str) -> list[int]:
    """A name as two 64-bit integers, the same on every machine."""
    return np.frombuffer(hashlib.sha256(name.encode()).digest()[:16], "<u8").tolist()


def _window(boxes: list[tuple[slice, slice]], margin: int, shape: tuple[int, ...]) -> tuple[slice, slice]:
    """The smallest window round all boxes, with a margin, inside the image."""
    top, bottom = min(b[0].start for b in boxes) - margin, max(b[0].stop for b in boxes) + margin
    left, right = min(b[1].start for b in boxes) - margin, max(b[1].stop for b in boxes) + margin
    return slice(max(top, 0), min(bottom, shape[0])), slice(max(left, 0), min(right, shape[1]))
