"""Mistakes of 2D segmentation models, made on purpose: masks dropped, merged, split and frayed.

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
_FRAY_PX = 24


@dataclass(frozen=True, slots=True)
class MaskNoise:
    """How masks go wrong. drop: share of masks missing from a frame, decided anew every `hold` frames; split:
    share of instances cut in two along a random line, decided anew every `split_frames` frames; merge: share of
    masks that swallow one they touch; jitter_px: most pixels a border moves in or out. Raises BadInput."""

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

    def keeps(self, frame_index: int, instance: int) -> bool:
        """Whether the instance's mask is not dropped in this frame."""
        rng = self._windowed(_DROP, frame_index, instance, self.hold)
        return self.drop == 0 or rng.random() >= self.drop

    def merged(self, frame_index: int, ids: Int32Array, present: Iterable[int]) -> dict[int, int]:
        """Which of the present instances are swallowed by which other that they touch in the id image."""
        kept = set(present)
        if self.merge == 0 or len(kept) < 2:
            return {}
        neighbours = touching(ids)
        swallowed: dict[int, int] = {}
        for eater in sorted(kept):
            rng = np.random.default_rng([self.seed, _MERGE, frame_index, eater])
            if eater in swallowed or rng.random() >= self.merge:
                continue
            free = sorted(
                n for n in neighbours.get(eater, ()) if n in kept - swallowed.keys() - set(swallowed.values())
            )
            if free:
                swallowed[free[rng.integers(len(free))]] = eater
        return swallowed

    def pieces(self, frame_index: int, instance: int, mask: BoolArray) -> list[BoolArray]:
        """The mask, or the two parts it is cut into in this frame; the line keeps its place in the mask's box."""
        if self.split == 0:
            return [mask]
        rng = self._windowed(_SPLIT, frame_index, instance, self.split_frames)
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

    def frayed(self, frame_index: int, instance: int, part: int, mask: BoolArray) -> BoolArray:
        """The mask with its border moved by a smooth random distance of at most jitter_px pixels; the array
        must have that much room round the mask wherever it may grow."""
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
        knots = rng.random((height // _FRAY_PX + 2, width // _FRAY_PX + 2), np.float32) * steps
        threshold = cv2.resize(knots, (width, height), interpolation=cv2.INTER_LINEAR)
        return level > np.minimum(threshold, steps - 1e-3).astype(np.uint8)

    def _windowed(self, kind: int, frame_index: int, instance: int, length: int) -> np.random.Generator:
        """A generator that stays the same for `length` frames; instances do not all change together."""
        return np.random.default_rng([self.seed, kind, (frame_index + 7 * instance) // length, instance])


FULL_NOISE = MaskNoise(drop=0.15, split=0.10, merge=0.05, jitter_px=3)


def check_noise_preset(noise: str) -> None:
    """Refuse a `noise` option that is neither "none" nor "full"; raises BadInput."""
    if noise not in ("none", "full"):
        raise BadInput(f"noise is none or full, not '{noise}'")


def touching(ids: Int32Array) -> dict[int, set[int]]:
    """For each positive id of an (H, W) image the other positive ids next to it (4-neighbours)."""
    neighbours: dict[int, set[int]] = {}
    for a, b in ((ids[:, :-1], ids[:, 1:]), (ids[:-1], ids[1:])):
        border = (a != b) & (a > 0) & (b > 0)
        for pair in np.unique(a[border].astype(np.int64) << 32 | b[border]).tolist():
            one, other = pair >> 32, pair & 0xFFFFFFFF
            neighbours.setdefault(one, set()).add(other)
            neighbours.setdefault(other, set()).add(one)
    return neighbours
