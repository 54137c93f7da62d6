"""Profile `detector`: a closed-set instance segmenter that misses small things, says a neighbouring class from some
sides, and sees things in texture for some frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from razer.arrays import BoolArray
from razer.frame import Frame, Masks
from razer.models.oracle.profiles.confusable_classes import SECTOR_FLIPS, UNSURE, Confusion, said_class
from razer.models.oracle.profiles.false_masks import FalseMasks
from razer.models.oracle.profiles.mask_shapes import coarse, strayed
from razer.models.oracle.profiles.visible_things import FOUND, HIDDEN, SECTORS, VisibleThings

MOST_FOUND = 0.92
HALF_FOUND_LOG_PX, LOG_PX_SCALE = 2.9, 0.25
CUT_FOUND = 0.8  # of that, for what the border of the image cuts
SCORE_BASE, SCORE_SLOPE, SCORE_SIGMA, FLIPPED_SCORE = 0.3, 0.6, 0.08, -0.15


@dataclass(frozen=True, slots=True)
class DetectorErrors:
    """What a detector errs in beyond size and border of the image.

    Args:
        confusion: of the class.
        hidden_sectors: in how many of six viewing sectors a thing is hard to find.
        hidden_found: factor of the probability that it is found from there.
        border_strays: whether borders also stray, as those of `sam` do.
    """

    confusion: Confusion = SECTOR_FLIPS
    hidden_sectors: int = 0
    hidden_found: float = 1.0
    border_strays: bool = False


DETECTOR = DetectorErrors()
# Set by what `razer bench --masks` says of small YOLO models on a real kitchen (docs/evaluation.md).
DETECTOR_HARD = DetectorErrors(UNSURE, hidden_sectors=2, hidden_found=0.5, border_strays=True)


class DetectorProfile:
    """Masks of things with names; a function of (seed, frame index, thing)."""

    def __init__(self, seed: int = 0, errors: DetectorErrors = DETECTOR) -> None:
        self.seed = seed
        self.errors = errors
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
            found *= self._found_from_here(things, thing)
            if rng.random() >= found:
                continue
            true_mask = things.ids == thing
            mask = coarse(strayed(true_mask, rng) if self.errors.border_strays else true_mask)
            if mask.any():
                name = said_class(things, thing, self.seed, self.errors.confusion)
                yield mask, _score(found, name != things.name(thing), rng), name

    def _found_from_here(self, things: VisibleThings, thing: int) -> float:
        """The factor of the probability that a thing is found from where it is seen."""
        if not self.errors.hidden_sectors:
            return 1.0
        rng = np.random.default_rng([self.seed, HIDDEN, thing])
        sectors = rng.permutation(SECTORS)[: self.errors.hidden_sectors]
        is_hidden = things.sector(thing, rng.uniform(0, 360 / SECTORS)) in sectors
        return self.errors.hidden_found if is_hidden else 1.0

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
