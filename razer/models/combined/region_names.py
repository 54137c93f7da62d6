"""Names for masks of segmenters that name nothing, from the classes that a semantic model sees beneath them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from razer.frame import Masks
from razer.models.mask_filters import shared_pixels

MAJORITY = 0.5  # share of a mask that one class must have to name it
PURE = 0.75  # share of a mask that stuff must have: one that spans wall and cupboard has not the borders of either
# Share of a piece that a mask must be of its size: a leg of a table, a panel of a wall, but not the cup on the one and
# the picture on the other, which a model that knows few classes does not see.
PART = 0.1


def named_by_regions(masks: Masks, regions: Masks) -> Masks:
    """The masks with the name of the class that has more than half of their pixels, and whether it is stuff; '' where
    none has, and where they are much smaller than its piece. Those that are half stuff and half something else are
    left out: the regions say what is what.

    Args:
        masks: N masks without names.
        regions: those of the segmenters that name what they find, with stuff flagged.
    """
    classes = list(zip(regions.class_names or (), regions.is_stuff.tolist(), strict=True))
    sparse, beneath = masks.masks[:, ::2, ::2], regions.masks[:, ::2, ::2]  # every second pixel: enough, and quicker
    area, piece_area = (np.count_nonzero(stack, axis=(1, 2)) for stack in (sparse, beneath))
    pixels = shared_pixels(sparse, beneath)
    names = np.full(len(masks), "", object)
    is_stuff, is_mixed = np.zeros((2, len(masks)), np.bool_)
    for name, stuff in dict.fromkeys(classes):
        of_class = np.flatnonzero([each == (name, stuff) for each in classes])
        piece = of_class[pixels[:, of_class].argmax(axis=1)]
        shared = pixels[:, of_class].sum(axis=1)
        is_part = (shared > MAJORITY * area) & (area >= PART * piece_area[piece])
        names[is_part] = name
        is_stuff |= is_part & stuff
        is_mixed |= is_part & stuff & (shared < PURE * area)
    return replace(masks, class_names=tuple(names), stuff=is_stuff).select(~is_mixed)
