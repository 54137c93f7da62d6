"""Profile `panoptic`: a semantic segmenter, which gives every pixel a class; its masks are connected pieces of one."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from scipy import ndimage

from razer.arrays import BoolArray, Int32Array
from razer.frame import Frame, Masks
from razer.models.oracle.profiles.confusable_classes import said_class
from razer.models.oracle.profiles.visible_things import WARP, VisibleThings

JITTER_PX = 2.0
_KNOT_SPACING_PX = 24


class PanopticProfile:
    """Masks with names that cover the image; a function of (seed, frame index)."""

    def __init__(self, seed: int = 0) -> None:
        self.seed = seed

    def masks(self, frame: Frame) -> Masks:
        """The masks of one frame; raises BadInput when it has no instance ids."""
        things = VisibleThings.of(frame, "segmenter")
        said = {thing: said_class(things, thing, self.seed) for thing in things.boxes}
        if not said:
            return Masks.none(*things.ids.shape)
        names = sorted(set(said.values()))
        class_of = np.zeros(max(said) + 1, np.int32)
        class_of[list(said)] = [names.index(name) for name in said.values()]
        classes = class_of[self._jittered(_nobody_filled(things.ids), frame.index)]
        pieces = [(mask, name) for number, name in enumerate(names) for mask in connected_pieces(classes == number)]
        masks = np.stack([mask for mask, _ in pieces])
        return Masks(masks, np.ones(len(masks), np.float32), tuple(name for _, name in pieces))

    def _jittered(self, ids: Int32Array, index: int) -> Int32Array:
        """The image with everything moved by a smooth random way of at most 2 px along rows and along columns."""
        height, width = ids.shape
        rng = np.random.default_rng([self.seed, WARP, index])
        shape = (2, height // _KNOT_SPACING_PX + 2, width // _KNOT_SPACING_PX + 2)
        y, x = (
            cv2.resize(knots, (width, height), interpolation=cv2.INTER_LINEAR)
            for knots in rng.uniform(-JITTER_PX, JITTER_PX, shape).astype(np.float32)
        )
        rows = np.rint(np.arange(height)[:, None] + y).astype(np.intp).clip(0, height - 1)
        columns = np.rint(np.arange(width) + x).astype(np.intp).clip(0, width - 1)
        return ids[rows, columns]


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
