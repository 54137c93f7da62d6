"""Recognition against true instance ids: recall of household things, and IoU of the large classes of rooms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from razer.arrays import BoolArray, Int32Array
from razer.frame import Frame, Masks

SEEN_PX = 1000  # of a thing in a 640x480 image, from which it counts; as large a share of other images
FOUND_IOU = 0.5
_REFERENCE_PX = 640 * 480

# What COCO, ADE20K and ScanNet200 call the same. A door's lining belongs to it, as in ADE20K.
THINGS: Mapping[str, frozenset[str]] = {
    "chair": frozenset({"chair", "office chair", "armchair"}),
    "couch": frozenset({"couch", "sofa"}),
    "bed": frozenset({"bed"}),
    "dining table": frozenset({"dining table", "table"}),
    "toilet": frozenset({"toilet"}),
    "tv": frozenset({"tv", "monitor"}),
    "potted plant": frozenset({"potted plant", "plant"}),
    "refrigerator": frozenset({"refrigerator"}),
    "oven": frozenset({"oven", "stove"}),
    "microwave": frozenset({"microwave"}),
    "sink": frozenset({"sink"}),
    "clock": frozenset({"clock", "alarm clock"}),
    "book": frozenset({"book"}),
    "bottle": frozenset({"bottle", "water bottle"}),
    "cup": frozenset({"cup"}),
}
SURFACES: Mapping[str, frozenset[str]] = {
    "wall": frozenset({"wall"}),
    "floor": frozenset({"floor"}),
    "ceiling": frozenset({"ceiling"}),
    "door": frozenset({"door", "doorframe"}),
    "bed": frozenset({"bed"}),
    "table": frozenset({"table", "dining table"}),
}


@dataclass
class Recognition:
    """Counts over frames: of each of THINGS how many were seen and how many of those found; of each of SURFACES the
    pixels that truth and masks share, and those of either."""

    n_frames: int = 0
    seen: dict[str, int] = field(default_factory=lambda: dict.fromkeys(THINGS, 0))
    found: dict[str, int] = field(default_factory=lambda: dict.fromkeys(THINGS, 0))
    shared_px: dict[str, int] = field(default_factory=lambda: dict.fromkeys(SURFACES, 0))
    either_px: dict[str, int] = field(default_factory=lambda: dict.fromkeys(SURFACES, 0))

    def add(self, frame: Frame, masks: Masks) -> None:
        """Compare the masks of a frame that has instance ids with these, by names."""
        ids = frame.instance_ids
        assert ids is not None
        self.n_frames += 1
        names = masks.class_names or ("",) * len(masks)
        for thing, words in THINGS.items():
            own = masks.masks[[name in words for name in names]]
            for true in _things(ids, frame.instance_classes, words):
                self.seen[thing] += 1
                self.found[thing] += _best_iou(true, own) >= FOUND_IOU
        for surface, words in SURFACES.items():
            true = np.isin(ids, [number for number, name in frame.instance_classes.items() if name in words])
            said = masks.masks[[name in words for name in names]].any(axis=0)
            self.shared_px[surface] += int((true & said).sum())
            self.either_px[surface] += int((true | said).sum())

    def to_json(self) -> dict[str, Any]:
        """The figures; those of classes that never came up are null, and no part of the means."""
        iou = {name: self.shared_px[name] / px if px else None for name, px in self.either_px.items()}
        there = [value for value in iou.values() if value is not None]
        n_seen = sum(self.seen.values())
        return {
            "frames": self.n_frames,
            "recall": sum(self.found.values()) / n_seen if n_seen else None,
            "things": {name: {"seen": self.seen[name], "found": self.found[name]} for name in THINGS},
            "miou": float(np.mean(there)) if there else None,
            "surfaces": iou,
        }


def _things(ids: Int32Array, classes: Mapping[int, str], words: frozenset[str]) -> list[BoolArray]:
    """The masks (H, W) of the instances of these classes that are large enough to count."""
    least = SEEN_PX * ids.size / _REFERENCE_PX
    masks = (ids == number for number, name in classes.items() if name in words)
    return [mask for mask in masks if mask.sum() >= least]


def _best_iou(true: BoolArray, masks: BoolArray) -> float:
    shared = (masks & true).sum(axis=(1, 2))
    either = (masks | true).sum(axis=(1, 2))
    return float((shared / np.maximum(either, 1)).max(initial=0.0))
