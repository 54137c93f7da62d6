"""Oracle embedding: one vector for each class name, with simulated errors."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from razer.arrays import Float32Array, Float64Array
from razer.errors import BadInput
from razer.frame import Frame, Masks
from razer.models.oracle.mask_noise import check_noise_preset
from razer.models.oracle.profiles.clip_profile import ClipProfile
from razer.models.oracle.profiles.visible_things import VisibleThings, largest

_FULL_COSINE = 0.7
_FULL_WRONG_CLASS = 0.1


class OracleEmbedder:
    """One unit vector for each class name, the same for the same seed, blurred to a given cosine.

    A mask without a class name has that of the thing that most of it shows.

    Args:
        noise: "none", or "full": cosine 0.7 to the class's vector, and 10 % vectors of another class of the recording.
        seed: of the class vectors and all random draws.
        dimension: length of the vectors.
        cosine: of each vector to its class's; replaces what `noise` sets.
        wrong_class: share of vectors of another class; replaces what `noise` sets.
        profile: clip: instead of all these, vectors as CLIP gives of crops (see ClipProfile).
        table: for profile clip, a file with names, text and image vectors.

    Raises:
        BadInput: for impossible options.
    """

    def __init__(
        self,
        noise: Literal["none", "full"] = "none",
        seed: int = 0,
        *,
        dimension: int = 64,
        cosine: float | None = None,
        wrong_class: float | None = None,
        profile: str | None = None,
        table: str | Path | None = None,
    ) -> None:
        check_noise_preset(noise)
        self.profile = _clip_profile(profile, table, seed)
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
        """Those of the table of profile clip; else empty: any name has its vector."""
        return () if self.profile is None else self.profile.table.known_names

    @property
    def unrelated_cosine(self) -> float:
        """The mean cosine of vectors of two classes."""
        return 0.0 if self.profile is None else self.profile.unrelated_cosine

    def embed_texts(self, texts: Sequence[str]) -> Float32Array:
        """The vectors (N, dimension) of class names; with profile clip those of CLIP's text side, and BadInput is
        raised for a name that the table lacks."""
        if self.profile is not None:
            return self.profile.table.embed_texts(texts)
        return np.stack([self.class_vector(name) for name in texts]).astype(np.float32)

    def embed(self, frame: Frame, masks: Masks) -> Float32Array:
        """A unit vector for each mask, (N, dimension) float32; raises BadInput for masks without class names on a
        frame without instance ids."""
        if self.profile is not None:
            return self.profile.embed(frame, masks)
        if not len(masks):
            return np.zeros((0, self.dimension), np.float32)
        names = _names_by_truth(frame, masks) if masks.class_names is None else masks.class_names
        classes = sorted({*frame.instance_classes.values(), *names})
        vectors = np.zeros((len(masks), self.dimension), np.float32)
        for number, (name, mask) in enumerate(zip(names, masks.masks, strict=True)):
            # Which masks reach the embedder, and in which order, depends on filters: the mask itself is the key.
            key = [self.seed, frame.index, int(mask.argmax()), int(np.count_nonzero(mask)), *_digest(name)]
            vectors[number] = self._blurred(self._assigned_class(name, classes, rng := np.random.default_rng(key)), rng)
        return vectors

    def _assigned_class(self, name: str, names: list[str], rng: np.random.Generator) -> str:
        """The class name, or with the probability wrong_class another one."""
        wrong = [other for other in names if other != name]
        return wrong[rng.integers(len(wrong))] if rng.random() < self.wrong_class and wrong else name

    def _blurred(self, name: str, rng: np.random.Generator) -> Float64Array:
        vector = self.class_vector(name)
        aside = rng.standard_normal(self.dimension)
        aside -= (aside @ vector) * vector
        aside /= np.linalg.norm(aside)
        return self.cosine * vector + np.sqrt(1 - self.cosine**2) * aside


def _clip_profile(profile: str | None, table: str | Path | None, seed: int) -> ClipProfile | None:
    """Raises BadInput for a profile that there is not, and for one without its table."""
    if profile is None:
        if table is not None:
            raise BadInput("the oracle embedder reads a table only for profile clip: add option profile = clip")
        return None
    if profile != "clip":
        raise BadInput(f"the oracle embedder has no profile '{profile}': it has clip")
    if table is None:
        raise BadInput(
            "the oracle embedder's profile clip needs option table: a NumPy archive with names, text and image vectors"
        )
    return ClipProfile(table, seed)


def _names_by_truth(frame: Frame, masks: Masks) -> tuple[str, ...]:
    """The class of what most of each mask shows; raises BadInput on a frame without instance ids."""
    if frame.instance_ids is None:
        raise BadInput("the oracle embedder needs masks with class names: use it with --segmenter oracle")
    things = VisibleThings.of(frame, "embedder")
    return tuple(things.name(largest(things.shares(mask))) for mask in masks.masks)


def _digest(name: str) -> list[int]:
    """A name as two 64-bit integers, the same on every machine."""
    return np.frombuffer(hashlib.sha256(name.encode()).digest()[:16], "<u8").tolist()
