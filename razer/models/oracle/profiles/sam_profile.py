"""Profile `sam`: class-agnostic masks of wholes, parts, unions and patches of texture, nested and overlapping."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np

from razer.arrays import BoolArray, Uint8Array
from razer.frame import Frame, Masks
from razer.models.mask_filters import best_of_overlapping
from razer.models.oracle.mask_noise import adjacent_ids
from razer.models.oracle.profiles.confusable_classes import GROUP_OF
from razer.models.oracle.profiles.mask_shapes import MARGIN_PX, blob, grown_window, strayed
from razer.models.oracle.profiles.visible_things import BLOBS, PROPOSED, VisibleThings, Window

WHOLE, PART, PARTS, THINGS, BLOB = 0.75, 0.6, 0.15, 0.05, 0.5  # probabilities of each kind of mask
SMALLEST_PART_PX = 400
BLOB_COUNT = (3.0, 2.0)  # mean and standard deviation on each wall, floor and table top
BLOB_SHARE = (0.005, 0.03)  # of the image
SMALL_PX, SMALL_MISSED = 100, 0.6
SCORE = (0.88, 0.06)  # mean and standard deviation, whatever the mask
MOST_IOU = 0.7  # of two masks that both stay

_TEXTURED = {"wall", "floor"}
_TABLES = set(GROUP_OF["table"])
_NO_PARTS = "the recording has no parts/: the oracle segmenter's profile sam proposes wholes alone (write it anew)"


class SamProfile:
    """Masks without names, best first; a function of (seed, frame index, thing, part)."""

    def __init__(self, seed: int = 0) -> None:
        self.seed = seed
        self._said = False

    def masks(self, frame: Frame) -> Masks:
        """The masks of one frame; raises BadInput when it has no instance ids."""
        things = VisibleThings.of(frame, "segmenter")
        if frame.part_ids is None and not self._said:
            self._said = True
            warnings.warn(_NO_PARTS, UserWarning, stacklevel=2)
        chosen: list[BoolArray] = []
        scores: list[float] = []
        for thing in things.boxes:
            rng = np.random.default_rng([self.seed, PROPOSED, frame.index, thing])
            for window, mask in self._of_thing(things, thing, rng):
                border = strayed(mask, rng)
                score = float(np.clip(rng.normal(*SCORE), 0, 1))
                is_missed = np.count_nonzero(mask) < SMALL_PX and rng.random() < SMALL_MISSED
                if border.any() and not is_missed:
                    canvas = np.zeros(things.ids.shape, np.bool_)
                    canvas[window] = border
                    chosen.append(canvas)
                    scores.append(score)
        if not chosen:
            return Masks.none(*things.ids.shape)
        masks, order = np.stack(chosen), np.array(scores, np.float32)
        # Every other pixel of every other row tells overlaps well enough, four times as fast.
        return Masks(masks, order).select(best_of_overlapping(masks[:, ::2, ::2], order, MOST_IOU))

    def _of_thing(
        self, things: VisibleThings, thing: int, rng: np.random.Generator
    ) -> Iterator[tuple[Window, BoolArray]]:
        """Windows of the image, and the true pixels in them that masks are drawn round."""
        window = grown_window(things.boxes[thing], MARGIN_PX, things.ids.shape)
        whole = things.mask(thing, window)
        if rng.random() < WHOLE:
            yield window, whole
        parts = None if things.is_stuff(thing) else things.parts(window)
        if parts is not None:
            yield from ((window, mask) for mask in _parts(np.where(whole, parts, np.uint8(0)), rng))
        yield from _union_of_things(things, thing, rng)
        surface = _textured(things.name(thing), whole, parts)
        if surface is not None:
            key = [self.seed, BLOBS, things.frame.index, thing]
            yield from ((window, mask) for mask in _blobs(surface, things.ids.size, np.random.default_rng(key)))


def _parts(parts: Uint8Array, rng: np.random.Generator) -> Iterator[BoolArray]:
    """Large parts of one thing (h, w; 0 = not of it), and a union of two or three that touch."""
    areas = np.bincount(parts.ravel())
    areas[0] = 0
    if np.count_nonzero(areas) < 2:
        return  # what is seen of the thing is that part
    for part in np.flatnonzero(areas >= SMALLEST_PART_PX):
        if rng.random() < PART:
            yield parts == part
    neighbours = adjacent_ids(parts.astype(np.int32))
    if rng.random() < PARTS and neighbours:
        yield np.isin(parts, _touching(neighbours, int(rng.integers(2, 4)), rng))


def _touching(neighbours: dict[int, set[int]], count: int, rng: np.random.Generator) -> list[int]:
    """Up to `count` numbers, each of which touches one before it."""
    chosen = [int(rng.choice(sorted(neighbours)))]
    while len(chosen) < count:
        next_to = sorted({other for one in chosen for other in neighbours[one]} - set(chosen))
        if not next_to:
            break
        chosen.append(int(rng.choice(next_to)))
    return chosen


def _union_of_things(things: VisibleThings, thing: int, rng: np.random.Generator) -> Iterator[tuple[Window, BoolArray]]:
    """The thing and another that it touches."""
    if rng.random() >= THINGS:
        return
    next_to = sorted(adjacent_ids(things.ids).get(thing, ()))
    if next_to:
        pair = [thing, int(rng.choice(next_to))]
        first, second = (things.boxes[one] for one in pair)
        rows, columns = (slice(min(a.start, b.start), max(a.stop, b.stop)) for a, b in zip(first, second, strict=True))
        window = grown_window((rows, columns), MARGIN_PX, things.ids.shape)
        yield window, np.isin(things.ids[window], pair)


def _textured(name: str, whole: BoolArray, parts: Uint8Array | None) -> BoolArray | None:
    """Where a thing has texture to be taken for things: all of a wall or floor, of a table the part seen that is
    highest in the image, its top."""
    if name in _TEXTURED:
        return whole
    if name not in _TABLES or parts is None:
        return whole if name in _TABLES else None
    areas = np.bincount(parts.ravel(), whole.ravel())
    rows = np.bincount(parts.ravel(), (whole * np.arange(len(whole))[:, None]).ravel())
    seen = np.flatnonzero(areas >= min(SMALLEST_PART_PX, areas.max()))
    return whole & (parts == seen[(rows[seen] / areas[seen]).argmin()])


def _blobs(surface: BoolArray, image_px: int, rng: np.random.Generator) -> Iterator[BoolArray]:
    for _ in range(max(round(rng.normal(*BLOB_COUNT)), 0)):
        area_px = round(image_px * rng.uniform(*BLOB_SHARE))
        if rng.random() < BLOB and (mask := blob(surface, area_px, rng)) is not None:
            yield mask
