"""Names for masks of segmenters that name nothing, from the classes that a semantic model sees beneath them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from razer.frame import Masks

MAJORITY = 0.5  # share of a mask that one class must have to name it


def named_by_regions(masks: Masks, regions: Masks, iou: float) -> Masks:
    """The masks with the name of the class of things that has more than half of their pixels, '' where none has.

    A mask that is the stuff beneath it, by an overlap of more than `iou` with all of its class, is left out: the stuff
    stands for it. Others on stuff stay, without a name: a picture hangs on the wall.

    Args:
        masks: N masks without names.
        regions: those of the segmenters that name what they find, with stuff flagged.
        iou: overlap above which two masks mean one thing.
    """
    classes = list(zip(regions.class_names or (), regions.is_stuff.tolist(), strict=True))
    sparse = masks.masks[:, ::2, ::2]
    area = np.maximum(np.count_nonzero(sparse, axis=(1, 2)), 1)
    names, is_stuff = [""] * len(masks), np.zeros(len(masks), np.bool_)
    for name, stuff in dict.fromkeys(classes):
        beneath = regions.masks[[each == (name, stuff) for each in classes]][:, ::2, ::2].any(axis=0)
        shared = np.count_nonzero(sparse & beneath, axis=(1, 2))
        for number in np.flatnonzero(shared > MAJORITY * area):
            names[number] = "" if stuff else name
            union = area[number] + np.count_nonzero(beneath) - shared[number]
            is_stuff[number] = stuff and shared[number] > iou * union
    return replace(masks, class_names=tuple(names)).select(~is_stuff)
