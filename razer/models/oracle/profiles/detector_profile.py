"""Profile `detector`: a closed-set instance segmenter that misses small things, says a neighbouring class from some
sides, and sees things in texture for some frames."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from razer.arrays import BoolArray
from razer.frame import Frame, Masks
from razer.models.oracle.profiles.confusable_classes import said_class
from razer.models.oracle.profiles.false_masks import FalseMasks
from razer.models.oracle.profiles.mask_shapes import coarse
from razer.models.oracle.profiles.visible_things import FOUND, VisibleThings

MOST_FOUND = 0.92
HALF_FOUND_LOG_PX, LOG_PX_SCALE = 2.9, 0.25
CUT_FOUND = 0.8  # of that, for what the border of the image cuts
SCORE_BASE, SCORE_SLOPE, SCORE_SIGMA, FLIPPED_SCORE = 0.3, 0.6, 0.08, -0.15


class DetectorProfile:
    """Masks of things with names; a function of (seed, frame index, thing)."""

    def __init__(self, seed: int = 0) -> None:
        self.seed = seed
        self._false_masks = FalseMasks(seed)

    def masks(self, frame: Frame) -> Masks:
        """The masks of one frame; raises BadInput when it has no instance ids."""
        things = VisibleThings.of(frame, "segmenter")
        found = [*self._found(things), *self._false(things)]
        if not found:
            return Masks.none(*things.ids.shape)
        masks, scores, names = zip(*found, strict=True)
        return Masks(np.stack(masks), np.array(scores, np.float32), names)

    def _found(self, things: VisibleThings) -> Iterator[tuple[BoolArray, float, str]]:
        for thing in things.boxes:
            if things.is_stuff(thing):
                continue
            rng = np.random.default_rng([self.seed, FOUND, things.frame.index, thing])
            found = probability_found(things.area_px(thing), things.is_cut(thing))
            mask = coarse(things.ids == thing)
            if rng.random() < found and mask.any():
                name = said_class(things, thing, self.seed)
                yield mask, _score(found, name != things.name(thing), rng), name

    def _false(self, things: VisibleThings) -> Iterator[tuple[BoolArray, float, str]]:
        for true_mask, name, key in self._false_masks.of(things):
            mask = coarse(true_mask)
            if mask.any():
                rng = np.random.default_rng([*key, things.frame.index])
                found = probability_found(int(np.count_nonzero(mask)), False)
                yield mask, _score(found, True, rng), name


def probability_found(area_px: int, is_cut: bool) -> float:
    """With which probability a detector finds what fills so many pixels, and may be cut by the border of the image."""
    logit = (np.log10(max(area_px, 1)) - HALF_FOUND_LOG_PX) / LOG_PX_SCALE
    return float(MOST_FOUND / (1 + np.exp(-logit))) * (CUT_FOUND if is_cut else 1.0)


def _score(found: float, is_wrong: bool, rng: np.random.Generator) -> float:
    score = SCORE_BASE + SCORE_SLOPE * found + rng.normal(0, SCORE_SIGMA) + (FLIPPED_SCORE if is_wrong else 0)
    return float(np.clip(score, 0, 1))
