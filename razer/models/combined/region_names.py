"""Names for masks of segmenters that name nothing, from the classes that a semantic model sees beneath them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from razer.frame import Masks
from razer.models.mask_filters import shared_pixels

MAJORITY = 0.5  # share of a mask that one class must have to name it
PART = 0.1  # share of a piece that a mask must be of its size: a leg of a table, not the cup on it


def named_by_regions(masks: Masks, regions: Masks, iou: float) -> Masks:
    """The masks with the name of the class of things that has more than half of their pixels, '' where none has or
    where they are much smaller than its piece: what lies on a table is not seen by models that know no such class.

    A mask that is the stuff beneath it, by an overlap of more than `iou` with all of its class, is left out: the stuff
    stands for it. Others on stuff stay, without a name: a picture hangs on the wall.

    Args:
        masks: N masks without names.
        regions: those of the segmenters that name what they find, with stuff flagged.
        iou: overlap above which two masks mean one thing.
    """
    classes = list(zip(regions.class_names or (), regions.is_stuff.tolist(), strict=True))
    sparse, beneath = masks.masks[:, ::2, ::2], regions.masks[:, ::2, ::2]  # every second pixel: enough, and quicker
    area, piece_area = (np.count_nonzero(stack, axis=(1, 2)) for stack in (sparse, beneath))
    pixels = shared_pixels(sparse, beneath)
    names, is_stuff = np.full(len(masks), "", object), np.zeros(len(masks), np.bool_)
    for name, stuff in dict.fromkeys(classes):
        of_class = np.flatnonzero([each == (name, stuff) for each in classes])
        shared = pixels[:, of_class].sum(axis=1)
        piece = of_class[pixels[:, of_class].argmax(axis=1)]
        is_of_class = shared > MAJORITY * area
        if stuff:
            is_stuff |= is_of_class & (shared > iou * (area + piece_area[of_class].sum() - shared))
        else:
            names[is_of_class & (area >= PART * piece_area[piece])] = name
    return replace(masks, class_names=tuple(names)).select(~is_stuff)
