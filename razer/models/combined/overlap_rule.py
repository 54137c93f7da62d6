"""The rule by which masks of several segmenters share an image: things before pieces of classes, these before stuff."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from razer.arrays import BoolArray
from razer.frame import Masks
from razer.models.mask_filters import mask_iou
from razer.models.semantic.class_pieces import connected_pieces

# Borders of class maps are coarse: so near to a detector's thing, at 480 rows, a piece of a class is its rim.
RIM_PIXELS = 8
MIN_PIXELS = 200  # at 640x480: what is left of a region where others came first, and is smaller, is a sliver


@dataclass(frozen=True)
class PartMasks:
    """The masks of one segmenter, and whether each of its things is one, or a piece of a class in which several
    may touch."""

    masks: Masks
    tells_instances: bool

    @property
    def stuff(self) -> BoolArray:
        """Which masks are stuff (N,); none of a segmenter that does not say so."""
        return np.zeros(len(self.masks), np.bool_) if self.masks.stuff is None else self.masks.stuff

    def things(self) -> Masks:
        """Masks of one thing each."""
        return self.masks.select(~self.stuff if self.tells_instances else np.zeros(len(self.masks), np.bool_))

    def thing_pieces(self) -> Masks:
        """Pieces of classes of things."""
        return self.masks.select(np.zeros(len(self.masks), np.bool_) if self.tells_instances else ~self.stuff)

    def stuff_pieces(self) -> Masks:
        """Pieces of stuff."""
        return self.masks.select(self.stuff)


def combine(parts: Sequence[PartMasks], iou: float) -> Masks:
    """The masks of one frame out of those of several segmenters.

    1. Things come first. Of two things of different segmenters whose masks overlap by more than `iou` the one with the
       better score stays, with equal scores that of the segmenter named first; others stay as they are, so nested
       ones too.
    2. A piece of a thing's class, from a segmenter that does not tell things apart, is left where no thing is and no
       such piece of an earlier segmenter, nor their rims; what is left of it falls into connected pieces.
    3. Stuff is what is left of it after both, and after stuff of earlier segmenters.

    Args:
        parts: at least one, of the same frame.
        iou: overlap of masks above which two segmenters mean one thing.
    """
    height, width = parts[0].masks.masks.shape[1:]
    enough = max(1, round(MIN_PIXELS * height * width / (640 * 480)))
    things = _best_of_several([part.things() for part in parts], iou)
    taken = things.masks.any(axis=0)
    kept = [_flagged(things, stuff=False)]
    for part in parts:
        pieces = _outside(part.thing_pieces(), _grown(taken), enough)
        taken = taken | pieces.masks.any(axis=0)
        kept.append(_flagged(pieces, stuff=False))
    for part in parts:
        stuff = part.stuff_pieces()
        left = replace(stuff, masks=stuff.masks & ~taken)
        left = left.select(np.count_nonzero(left.masks, axis=(1, 2)) >= enough)
        taken = taken | left.masks.any(axis=0)
        kept.append(_flagged(left, stuff=True))
    return concatenated(kept)


def _best_of_several(parts: Sequence[Masks], iou: float) -> Masks:
    """The things of all parts, without those that overlap a better one of another part by more than `iou`."""
    things = concatenated(parts)
    part_of = np.repeat(np.arange(len(parts)), [len(part) for part in parts])
    overlaps = mask_iou(things.masks[:, ::2, ::2]) > iou  # on every second pixel: a quarter of the time
    rivals = overlaps & (part_of[:, None] != part_of[None])
    is_kept = np.ones(len(things), np.bool_)
    for index in np.argsort(-things.scores, kind="stable"):
        if is_kept[index]:
            is_kept &= ~rivals[index]
    return things.select(is_kept)


def _grown(taken: BoolArray) -> BoolArray:
    """What is taken (H, W), with its rim."""
    size = 2 * round(RIM_PIXELS * len(taken) / 480) + 1
    return cv2.dilate(taken.view(np.uint8), np.ones((size, size), np.uint8)).astype(np.bool_)


def _outside(pieces: Masks, taken: BoolArray, enough: int) -> Masks:
    """The pieces outside of what is taken (H, W): untouched ones as they are, of others each connected piece that has
    enough pixels."""
    sources: list[int] = []
    masks: list[BoolArray] = []
    for number, piece in enumerate(pieces.masks):
        left = connected_pieces(piece & ~taken, enough) if (piece & taken).any() else [piece]
        sources += [number] * len(left)
        masks += left
    chosen = pieces.select(np.array(sources, np.intp))
    return replace(chosen, masks=np.stack(masks)) if masks else chosen


def _flagged(masks: Masks, *, stuff: bool) -> Masks:
    return replace(masks, stuff=np.full(len(masks), stuff, np.bool_))


def concatenated(parts: Sequence[Masks]) -> Masks:
    """All masks, in the order of the parts; those of a part without names bear the empty one where others have some,
    and those of a part that knows of no stuff are things."""
    no_names = all(part.class_names is None for part in parts)
    no_stuff = all(part.stuff is None for part in parts)
    names = tuple(name for part in parts for name in part.class_names or [""] * len(part))
    stuff = [np.zeros(len(part), np.bool_) if part.stuff is None else part.stuff for part in parts]
    return Masks(
        np.concatenate([part.masks for part in parts]),
        np.concatenate([part.scores for part in parts]),
        None if no_names else names,
        None if no_stuff else np.concatenate(stuff),
    )
