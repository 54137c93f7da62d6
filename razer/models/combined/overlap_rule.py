"""The rule by which masks of several segmenters share an image: things before pieces of classes, these before stuff."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from razer.arrays import BoolArray, Float32Array
from razer.frame import Masks
from razer.models.combined.region_names import named_by_regions
from razer.models.mask_filters import mask_iou, shared_pixels
from razer.models.semantic.class_pieces import connected_pieces

# Borders of class maps are coarse: so near to a thing that a piece covers, at 480 rows, it is the thing's rim.
RIM_PIXELS = 8
COVERED = 0.5  # share of a thing that a piece covers which means it: a chair's piece, not the cabinet behind it
MIN_PIXELS = 200  # at 640x480: what is left of a region where others came first, and is smaller, is a sliver


@dataclass(frozen=True)
class PartMasks:
    """The masks of one segmenter, and whether each of its things is one, or a piece of a class in which several
    may touch."""

    masks: Masks
    tells_instances: bool

    def things(self) -> Masks:
        """Masks of one thing each."""
        return self.masks.select(~self.masks.is_stuff & self.tells_instances)

    def thing_pieces(self) -> Masks:
        """Pieces of classes of things."""
        return self.masks.select(~self.masks.is_stuff & (not self.tells_instances))

    def stuff_pieces(self) -> Masks:
        """Pieces of stuff."""
        return self.masks.select(self.masks.is_stuff)


def combine(parts: Sequence[PartMasks], iou: float) -> Masks:
    """The masks of one frame out of those of several segmenters.

    1. A mask of a segmenter that names nothing takes the name of the class that a semantic segmenter sees beneath it
       (see named_by_regions).
    2. Things come first. Of two things of different segmenters whose masks overlap by more than `iou` one stays: that
       of a segmenter that names things itself, else the one with the better score, with equal scores that of the
       segmenter named first. Others stay as they are, so nested ones too.
    3. Stuff of segmenters that tell things apart, and masks that step 1 called stuff, are left where no thing is: they
       have finer borders than pieces of classes.
    4. A piece of a thing's class, from a segmenter that does not tell things apart, is left where none of these is and
       no such piece of an earlier segmenter, nor the rim or a hole of a thing that it covers by more than half (what
       lies on a table is not another one); what is left of it falls into connected pieces.
    5. All other stuff is what is left of it. Stuff of one class that touches is one mask, whoever saw it.

    Args:
        parts: at least one, of the same frame.
        iou: overlap of masks above which two segmenters mean one thing.
    """
    height, width = parts[0].masks.masks.shape[1:]
    enough = max(1, round(MIN_PIXELS * height * width / (640 * 480)))
    names_itself = [part.masks.class_names is not None for part in parts]
    parts = _named(parts)
    things = _best_of_several([part.things() for part in parts], names_itself, iou)
    counted = _flagged(things, stuff=False)
    fine = _left([part.stuff_pieces() for part in parts if part.tells_instances], counted)
    for part in parts:
        pieces = _outside(part.thing_pieces(), concatenated([counted, fine]), enough)
        counted = concatenated([counted, _flagged(pieces, stuff=False)])
    coarse = _left([part.stuff_pieces() for part in parts if not part.tells_instances], concatenated([counted, fine]))
    seen = concatenated([part.stuff_pieces() for part in parts])
    return concatenated([counted, _joined(concatenated([fine, coarse]), seen, enough)])


def _left(parts: Sequence[Masks], before: Masks) -> Masks:
    """What is left of stuff where other masks came before, and that of earlier parts, and better ones of its own."""
    stuff = _flagged(concatenated([before.select(np.zeros(len(before), np.bool_)), *parts]), stuff=True)
    ranks = np.repeat(np.arange(len(parts)), [len(part) for part in parts])
    taken, left = before.masks.any(axis=0), stuff.masks.copy()
    for index in np.lexsort((-stuff.scores, ranks)):
        left[index] &= ~taken
        taken |= left[index]
    return replace(stuff, masks=left)


def _joined(stuff: Masks, seen: Masks, enough: int) -> Masks:
    """Stuff of one class as one mask wherever it was seen connected, with the score of its largest part; slivers are
    dropped.

    Args:
        stuff: what is left of it.
        seen: all of it, before things were cut out: a floor behind the legs of a chair is one.
        enough: pixels below which a mask is a sliver.
    """
    joined: list[tuple[BoolArray, np.float32, str]] = []
    names, seen_names = (np.array(masks.class_names or [""] * len(masks), object) for masks in (stuff, seen))
    for name in dict.fromkeys(names):
        own = np.flatnonzero(names == name)
        for region in connected_pieces(seen.masks[seen_names == name].any(axis=0), 1):
            shares = np.array([np.count_nonzero(stuff.masks[i] & region) for i in own])
            if shares.sum() >= enough:
                mask = stuff.masks[own].any(axis=0) & region
                joined.append((mask, stuff.scores[own[shares.argmax()]], name))
    if not joined:
        return stuff.select(np.zeros(len(stuff), np.bool_))
    masks, scores, classes = zip(*joined, strict=True)
    class_names = None if stuff.class_names is None else classes
    return Masks(np.stack(masks), np.array(scores, np.float32), class_names, np.ones(len(masks), np.bool_))


def _named(parts: Sequence[PartMasks]) -> Sequence[PartMasks]:
    regions = [part.masks for part in parts if not part.tells_instances]
    if not regions:
        return parts
    beneath = concatenated(regions)
    return [
        part if part.masks.class_names is not None else replace(part, masks=named_by_regions(part.masks, beneath))
        for part in parts
    ]


def _best_of_several(parts: Sequence[Masks], names_itself: Sequence[bool], iou: float) -> Masks:
    """The things of all parts, without those that overlap a better one of another part by more than `iou`: a detector
    knows what it looks for, and scores of masks that anything has mean something else."""
    things = concatenated(parts)
    part_of = np.repeat(np.arange(len(parts)), [len(part) for part in parts])
    order = np.lexsort((-things.scores, ~np.array(names_itself)[part_of]))
    overlaps = mask_iou(things.masks[:, ::2, ::2]) > iou  # on every second pixel: a quarter of the time
    rivals = overlaps & (part_of[:, None] != part_of[None])
    is_kept = np.ones(len(things), np.bool_)
    for index in order:
        if is_kept[index]:
            is_kept &= ~rivals[index]
    return things.select(is_kept)


def _grown(masks: BoolArray) -> BoolArray:
    """What masks (N, H, W) take of an image (H, W), with their rims and with what each encloses."""
    taken = np.zeros(masks.shape[1:], np.uint8)
    for mask in masks:
        outlines, _ = cv2.findContours(mask.view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        cv2.drawContours(taken, outlines, -1, 1, cv2.FILLED)
    size = 2 * round(RIM_PIXELS * len(taken) / 480) + 1
    return cv2.dilate(taken, np.ones((size, size), np.uint8)).astype(np.bool_)


def _outside(pieces: Masks, others: Masks, enough: int) -> Masks:
    """The pieces outside of other masks: untouched ones as they are, of others each connected piece that has enough
    pixels."""
    taken = others.masks.any(axis=0)
    is_covered = _covered_share(others.masks, pieces.masks) > COVERED
    sources: list[int] = []
    masks: list[BoolArray] = []
    for number, piece in enumerate(pieces.masks):
        left = [piece]
        if (piece & taken).any():
            rims = _grown(others.masks[is_covered[:, number]])
            left = connected_pieces(piece & ~taken & ~rims, enough)
        sources += [number] * len(left)
        masks += left
    chosen = pieces.select(np.array(sources, np.intp))
    return replace(chosen, masks=np.stack(masks)) if masks else chosen


def _covered_share(masks: BoolArray, pieces: BoolArray) -> Float32Array:
    """The share of each mask (M, H, W) that each piece (N, H, W) covers, (M, N), by every second pixel."""
    sparse = masks[:, ::2, ::2]
    area = np.maximum(np.count_nonzero(sparse, axis=(1, 2)), 1)
    return (shared_pixels(sparse, pieces[:, ::2, ::2]) / area[:, None]).astype(np.float32)


def _flagged(masks: Masks, *, stuff: bool) -> Masks:
    return replace(masks, stuff=np.full(len(masks), stuff, np.bool_))


def concatenated(parts: Sequence[Masks]) -> Masks:
    """All masks, in the order of the parts; those of a part without names bear the empty one where others have some,
    and those of a part that knows of no stuff are things."""
    no_names = all(part.class_names is None for part in parts)
    no_stuff = all(part.stuff is None for part in parts)
    names = tuple(name for part in parts for name in part.class_names or [""] * len(part))
    return Masks(
        np.concatenate([part.masks for part in parts]),
        np.concatenate([part.scores for part in parts]),
        None if no_names else names,
        None if no_stuff else np.concatenate([part.is_stuff for part in parts]),
    )
