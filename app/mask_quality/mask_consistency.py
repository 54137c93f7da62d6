"""Consistency of masks from view to view, without a truth: masks are carried into the next view by depth and poses."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from razer.arrays import BoolArray, Float32Array, Int64Array
from razer.frame import Frame, Masks
from razer.geometry import back_project, inverse, project, transform_points

SIZES_PX = (0, 300, 1000, 3000, 10000)  # of a mask: lower bounds of the bins
SAME_IOU = 0.5  # from which two masks are of one thing
MOSTLY_SEEN = 0.8  # share of a mask that the other view has to show
_DEPTH_TOLERANCE = 0.03  # of the distance, between what two views say of a point
_STEP_PX = 2  # between the pixels that are carried


@dataclass(frozen=True)
class View:
    """A posed frame and its masks."""

    frame: Frame
    masks: Masks


@dataclass(frozen=True)
class Carried:
    """What became of the masks of one view in another that shows most of them: sizes (N,) in pixels of the first, and
    of its best match in the other the IoU (N,) and whether it has another name (N,), where both have names."""

    sizes_px: Int64Array
    iou: Float32Array
    renamed: BoolArray

    @property
    def missed(self) -> BoolArray:
        """Which of them (N,) have no match."""
        missed: BoolArray = self.iou < SAME_IOU
        return missed


@dataclass
class MaskConsistency:
    """Statistics of masks over neighbouring views."""

    n_views: int = 0
    n_masks: int = 0
    seen_shares: list[float] = field(default_factory=list)
    carried: list[Carried] = field(default_factory=list)
    missed_twice: list[BoolArray] = field(default_factory=list)

    @classmethod
    def of(cls, views: Iterable[View]) -> MaskConsistency:
        """Those of views in the order in which they were taken; three are held at a time."""
        result = cls()
        before: list[View] = []
        for view in views:
            result._add(view, before)
            before = [*before, view][-2:]
        return result

    def to_json(self) -> dict[str, Any]:
        """The statistics; what nothing was counted for is null."""
        sizes, iou, renamed = (
            np.concatenate([np.zeros(0), *(getattr(one, name) for one in self.carried)])
            for name in ("sizes_px", "iou", "renamed")
        )
        missed = iou < SAME_IOU
        bounds = [*pairwise((*SIZES_PX, None))]
        bins = np.digitize(sizes, SIZES_PX[1:])
        return {
            "views": self.n_views,
            "masks_a_view": self.n_masks / max(self.n_views, 1),
            "seen_again": _mean(self.seen_shares),
            "compared": len(sizes),
            "missed": _mean(missed),
            "missed_again": _mean(np.concatenate([np.zeros(0), *self.missed_twice])),
            "missed_by_size": [
                {"from_px": low, "to_px": high, "compared": int((bins == i).sum()), "missed": _mean(missed[bins == i])}
                for i, (low, high) in enumerate(bounds)
            ],
            "renamed": _mean(renamed[~missed]),
            "iou": _mean(iou[~missed]),
        }

    def _add(self, view: View, before: Sequence[View]) -> None:
        self.n_views += 1
        self.n_masks += len(view.masks)
        if not before:
            return
        previous = before[-1]
        for a, b in ((previous, view), (view, previous)):
            pixels = carried_pixels(a.frame, b.frame)
            self.seen_shares.append(len(pixels[0]) / max(int(np.count_nonzero(_sampled(b.frame))), 1))
            self.carried.append(carry(a, b, pixels)[0])
        if len(before) > 1:
            self.missed_twice.append(_missed_again(view, before[-1], before[0]))


def carry(a: View, b: View, pixels: tuple[Int64Array, Int64Array] | None = None) -> tuple[Carried, BoolArray]:
    """What became of a's masks in b, and which of them (N,) b shows well enough to be asked.

    Args:
        a: the view whose masks are looked for.
        b: the view in which they are.
        pixels: of both, as `carried_pixels` gives them, if they are known.
    """
    in_a, in_b = carried_pixels(a.frame, b.frame) if pixels is None else pixels
    back, _ = carried_pixels(b.frame, a.frame)[::-1]
    seen = np.zeros(a.frame.depth.size, np.bool_)
    seen[back] = True
    ours, theirs = (view.masks.masks.reshape(len(view.masks), view.frame.depth.size) for view in (a, b))
    sampled = _sampled(a.frame).ravel()
    areas = (ours & sampled).sum(axis=1)
    asked = ((ours & seen).sum(axis=1) >= MOSTLY_SEEN * areas) & (areas > 0)
    iou = _iou(ours[asked][:, in_a], theirs[:, in_b])
    best = iou.argmax(axis=1) if len(theirs) else np.zeros(len(iou), np.intp)
    best_iou = iou.max(axis=1, initial=0)
    sizes = np.count_nonzero(ours[asked], axis=1).astype(np.int64)
    return Carried(sizes, best_iou, _renamed(a.masks, b.masks, np.flatnonzero(asked), best)), asked


def carried_pixels(a: Frame, b: Frame) -> tuple[Int64Array, Int64Array]:
    """Pixels of a and b, (N,) indices into the flattened images, that show the same points: every other pixel of every
    other row of b, and where a shows what it shows."""
    rows, columns = np.nonzero(_sampled(b))
    points = back_project(columns, rows, b.depth[rows, columns], b.intrinsics.matrix)
    u, v, z = project(transform_points(inverse(a.pose) @ b.pose, points), a.intrinsics.matrix)
    inside = (z > 0) & (u > -0.5) & (v > -0.5) & (u < a.intrinsics.width - 0.5) & (v < a.intrinsics.height - 0.5)
    rows, columns, z = rows[inside], columns[inside], z[inside]
    in_a = np.rint(v[inside]).astype(np.int64) * a.intrinsics.width + np.rint(u[inside]).astype(np.int64)
    same = np.abs(a.depth.ravel()[in_a] - z) < _DEPTH_TOLERANCE * z
    return in_a[same], (rows * b.intrinsics.width + columns)[same]


def _missed_again(last: View, middle: View, first: View) -> BoolArray:
    """Of the first view's masks that the middle one misses, and which the last one shows as well, whether that misses
    them too."""
    next_, asked = carry(first, middle)
    after, asked_after = carry(first, last)
    missed, missed_after = np.zeros((2, len(asked)), np.bool_)
    missed[asked], missed_after[asked_after] = next_.missed, after.missed
    return missed_after[missed & asked_after]


def _sampled(frame: Frame) -> BoolArray:
    """The pixels (H, W) that are carried: those of a grid that have depth."""
    sampled = np.zeros(frame.depth.shape, np.bool_)
    sampled[::_STEP_PX, ::_STEP_PX] = frame.depth[::_STEP_PX, ::_STEP_PX] > 0
    return sampled


def _iou(ours: BoolArray, theirs: BoolArray) -> Float32Array:
    """Intersection over union (N, M) of masks (N, P) and (M, P); 0 for two empty ones."""
    a, b = ours.astype(np.float32), theirs.astype(np.float32)
    shared = a @ b.T
    union = a.sum(axis=1)[:, None] + b.sum(axis=1) - shared
    iou: Float32Array = shared / np.maximum(union, 1)
    return iou


def _renamed(a: Masks, b: Masks, asked: Int64Array, best: Int64Array) -> BoolArray:
    if a.class_names is None or b.class_names is None or not len(b):
        return np.zeros(len(asked), np.bool_)
    pairs = zip(asked, best, strict=True)
    return np.array([a.class_names[i] != b.class_names[j] for i, j in pairs], np.bool_)


def _mean(values: Any) -> float | None:
    return float(np.mean(values)) if len(values) else None
