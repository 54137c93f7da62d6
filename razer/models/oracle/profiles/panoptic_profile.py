"""Profile `panoptic`: a semantic segmenter, which gives every pixel a class; its masks are connected pieces of one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage

from razer.arrays import BoolArray, Int32Array
from razer.frame import Frame, Masks
from razer.models.oracle.mask_noise import adjacent_ids
from razer.models.oracle.profiles.confusable_classes import SECTOR_FLIPS, Confusion, said_class
from razer.models.oracle.profiles.visible_things import SWALLOWED, WARP, VisibleThings
from razer.models.stuff_names import stuff_classes

_KNOT_SPACING_PX = 24


@dataclass(frozen=True, slots=True)
class PanopticErrors:
    """What a semantic segmenter errs in.

    Args:
        confusion: of the class.
        jitter_px: by which the image moves at most, along rows and along columns.
        half_seen_px: size of a thing at which every other one is swallowed by what it touches; 0 = none is.
        blotches: mean number of patches of 20 to 3000 pixels a frame that are called by another class of the frame.
    """

    confusion: Confusion = SECTOR_FLIPS
    jitter_px: float = 2.0
    half_seen_px: float = 0.0
    blotches: int = 0


PANOPTIC = PanopticErrors()
# Set by what `razer bench --masks` says of a small model on a real kitchen (docs/evaluation.md).
PANOPTIC_HARD = PanopticErrors(jitter_px=5.0, half_seen_px=2500.0, blotches=32)
_SEEN_LOG_PX_SCALE = 0.25
_BLOTCH_LOG_PX = (1.3, 3.5)


class PanopticProfile:
    """Masks with names that cover the image; a function of (seed, frame index, thing)."""

    def __init__(self, seed: int = 0, errors: PanopticErrors = PANOPTIC) -> None:
        self.seed = seed
        self.errors = errors

    def masks(self, frame: Frame) -> Masks:
        """The masks of one frame; raises BadInput when it has no instance ids."""
        things = VisibleThings.of(frame, "segmenter")
        if not things.boxes:
            return Masks.none(*things.ids.shape)
        said = self._said(things)
        names = sorted(set(said.values()))
        class_of = np.zeros(max(said) + 1, np.int32)
        class_of[list(said)] = [names.index(name) for name in said.values()]
        rng = np.random.default_rng([self.seed, WARP, frame.index])
        classes = class_of[self._jittered(_nobody_filled(things.ids), rng)]
        self._blotch(classes, len(names), rng)
        pieces = [(mask, name) for number, name in enumerate(names) for mask in connected_pieces(classes == number)]
        masks = np.stack([mask for mask, _ in pieces])
        said_names = tuple(name for _, name in pieces)
        return Masks(masks, np.ones(len(masks), np.float32), said_names, stuff_classes(said_names))

    def _said(self, things: VisibleThings) -> dict[int, str]:
        """What each thing is called: from its side, or by the name of what swallows it."""
        said = {thing: said_class(things, thing, self.seed, self.errors.confusion) for thing in things.boxes}
        if not self.errors.half_seen_px:
            return said
        neighbours = adjacent_ids(things.ids)
        swallowed = dict(said)
        for thing in things.boxes:
            logit = np.log10(things.area_px(thing) / self.errors.half_seen_px) / _SEEN_LOG_PX_SCALE
            rng = np.random.default_rng([self.seed, SWALLOWED, things.frame.index, thing])
            if neighbours.get(thing) and rng.random() > 1 / (1 + np.exp(-logit)):
                swallowed[thing] = said[max(neighbours[thing], key=lambda other: (things.area_px(other), other))]
        return swallowed

    def _jittered(self, ids: Int32Array, rng: np.random.Generator) -> Int32Array:
        """The image with everything moved by a smooth random way, which is limited along rows and along columns."""
        height, width = ids.shape
        shape = (2, height // _KNOT_SPACING_PX + 2, width // _KNOT_SPACING_PX + 2)
        y, x = (
            cv2.resize(knots, (width, height), interpolation=cv2.INTER_LINEAR)
            for knots in rng.uniform(-self.errors.jitter_px, self.errors.jitter_px, shape).astype(np.float32)
        )
        rows = np.rint(np.arange(height)[:, None] + y).astype(np.intp).clip(0, height - 1)
        columns = np.rint(np.arange(width) + x).astype(np.intp).clip(0, width - 1)
        return ids[rows, columns]

    def _blotch(self, classes: Int32Array, n_classes: int, rng: np.random.Generator) -> None:
        """Draw ellipses of other classes over the class image, in place."""
        height, width = classes.shape
        for _ in range(int(rng.poisson(self.errors.blotches))):
            area_px, aspect = 10 ** rng.uniform(*_BLOTCH_LOG_PX), rng.uniform(1, 3)
            across = float(np.sqrt(area_px / (np.pi * aspect)))
            center = int(rng.integers(width)), int(rng.integers(height))
            axes = max(round(across * aspect), 1), max(round(across), 1)
            number = int(rng.integers(n_classes))
            cv2.ellipse(classes, center, axes, rng.uniform(0, 180), 0, 360, number, -1)


def _nobody_filled(ids: Int32Array) -> Int32Array:
    """The ids, those of the nearest thing where there is none."""
    if (ids > 0).all():
        return ids
    rows, columns = ndimage.distance_transform_edt(ids <= 0, return_distances=False, return_indices=True)
    filled: Int32Array = ids[rows, columns]
    return filled


def connected_pieces(mask: BoolArray) -> Iterator[BoolArray]:
    """The pieces of a mask (H, W) whose pixels touch by their sides."""
    count, pieces = cv2.connectedComponents(mask.astype(np.uint8), connectivity=4)
    yield from (pieces == number for number in range(1, count))
