"""Simulated errors of 2D segmentation: masks dropped, merged, split, and with jittered borders.

Everything is a pure function of (seed, frame index, instance id): the order of frames and the number of
threads change nothing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np

from razer.arrays import BoolArray, Int32Array
from razer.errors import BadInput

_DROP, _SPLIT, _LINE, _MERGE, _JITTER = range(5)
_RING = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))
_KNOT_SPACING_PX = 24  # of the random field that moves borders


@dataclass(frozen=True, slots=True)
class MaskNoise:
    """Which errors masks have.

    Args:
        seed: of all random draws.
        drop: share of masks missing from a frame, drawn afresh every `hold` frames.
        hold: frames.
        split: share of instances cut in two along a random line, drawn afresh every `split_frames` frames.
        split_frames: frames.
        merge: share of masks that absorb an adjacent one.
        jitter_px: largest distance that a border moves in or out, pixels.

    Raises:
        BadInput: for impossible values.
    """

    seed: int = 0
    drop: float = 0.0
    hold: int = 1
    split: float = 0.0
    split_frames: int = 5
    merge: float = 0.0
    jitter_px: int = 0

    def __post_init__(self) -> None:
        for name in ("drop", "split", "merge"):
            if not 0 <= getattr(self, name) <= 1:
                raise BadInput(f"{name} is a share of masks: use 0 to 1, not {getattr(self, name)}")
        if self.hold < 1 or self.split_frames < 1:
            raise BadInput("hold and split_frames count frames: use 1 or more")
        if not 0 <= self.jitter_px <= 20:
            raise BadInput(f"jitter_px is 0 to 20 pixels, not {self.jitter_px}")

    def is_kept(self, frame_index: int, instance: int) -> bool:
        """Whether the instance's mask is not dropped in this frame."""
        rng = self._window_rng(_DROP, frame_index, instance, self.hold)
        return self.drop == 0 or rng.random() >= self.drop

    def absorbed_by(self, frame_index: int, ids: Int32Array, present: Iterable[int]) -> dict[int, int]:
        """The instances that are merged into an adjacent one in the id image: absorbed -> absorbing."""
        instances = set(present)
        if self.merge == 0 or len(instances) < 2:
            return {}
        neighbours = adjacent_ids(ids)
        absorbing: dict[int, int] = {}
        for instance in sorted(instances):
            rng = np.random.default_rng([self.seed, _MERGE, frame_index, instance])
            if instance in absorbing or rng.random() >= self.merge:
                continue
            unmerged = instances - absorbing.keys() - set(absorbing.values())
            absorbable = sorted(unmerged & neighbours.get(instance, set()))
            if absorbable:
                absorbing[absorbable[rng.integers(len(absorbable))]] = instance
        return absorbing

    def split_parts(self, frame_index: int, instance: int, mask: BoolArray) -> list[BoolArray]:
        """The mask, or the two parts it is cut into in this frame; the line keeps its position in the mask's box."""
        if self.split == 0:
            return [mask]
        rng = self._window_rng(_SPLIT, frame_index, instance, self.split_frames)
        if rng.random() >= self.split:
            return [mask]
        angle, offset = rng.uniform(0, np.pi), rng.uniform(-0.15, 0.15)
        rows, columns = np.nonzero(mask)
        y, x = rows / mask.shape[0], columns / mask.shape[1]
        side = np.cos(angle) * (x - x.mean()) + np.sin(angle) * (y - y.mean()) > offset
        first = np.zeros_like(mask)
        first[rows[side], columns[side]] = True
        second = mask & ~first
        return [first, second] if first.any() and second.any() else [mask]

    def jittered(self, frame_index: int, instance: int, part: int, mask: BoolArray) -> BoolArray:
        """The mask with its border moved by a smooth random distance of at most jitter_px pixels.

        Args:
            frame_index: of the frame.
            instance: its id.
            part: which part of the split mask it is.
            mask: (h, w), with a margin of jitter_px pixels wherever it may grow.
        """
        if self.jitter_px == 0:
            return mask
        rng = np.random.default_rng([self.seed, _JITTER, frame_index, instance, part])
        grown = shrunk = mask.astype(np.uint8)
        level = grown.copy()
        for _ in range(self.jitter_px):
            grown, shrunk = cv2.dilate(grown, _RING), cv2.erode(shrunk, _RING, borderValue=1)
            level += grown
            level += shrunk
        # `level` steps from 0 (far outside) to 2 n + 1 (deep inside); n + 1 is the border itself.
        steps = 2 * self.jitter_px + 1
        height, width = mask.shape
        knots = rng.random((height // _KNOT_SPACING_PX + 2, width // _KNOT_SPACING_PX + 2), np.float32) * steps
        threshold = cv2.resize(knots, (width, height), interpolation=cv2.INTER_LINEAR)
        return level > np.minimum(threshold, steps - 1e-3).astype(np.uint8)

    def _window_rng(self, kind: int, frame_index: int, instance: int, length: int) -> np.random.Generator:
        """A generator that stays the same for `length` frames; instances do not all change together."""
        return np.random.default_rng([self.seed, kind, (frame_index + 7 * instance) // length, instance])


FULL_NOISE = MaskNoise(drop=0.15, split=0.10, merge=0.05, jitter_px=3)


def check_noise_preset(noise: str) -> None:
    """Refuse a `noise` option that is neither "none" nor "full"; raises BadInput."""
    if noise not in ("none", "full"):
        raise BadInput(f"noise is none or full, not '{noise}'")


def adjacent_ids(ids: Int32Array) -> dict[int, set[int]]:
    """For each positive id of an (H, W) image the other positive ids next to it (4-neighbours)."""
    neighbours: dict[int, set[int]] = {}
    for a, b in ((ids[:, :-1], ids[:, 1:]), (ids[:-1], ids[1:])):
        border = (a != b) & (a > 0) & (b > 0)
        for pair in np.unique(a[border].astype(np.int64) << 32 | b[border]).tolist():
            one, other = pair >> 32, pair & 0xFFFFFFFF
            neighbours.setdefault(one, set()).add(other)
            neighbours.setdefault(other, set()).add(one)
    return neighbours
