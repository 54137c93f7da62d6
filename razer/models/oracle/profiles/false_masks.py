"""False masks of a detector: patches of textured stuff that it takes for a thing, for some frames on end."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from razer.arrays import BoolArray, Float64Array, Int64Array
from razer.geometry import back_project, transform_points
from razer.models.oracle.profiles.visible_things import FALSE, STUFF, VisibleThings

FALSE_A_FRAME = 0.3
LASTING_FRAMES = (5, 15)
RADIUS_M = (0.1, 0.3)
_CELL_M = 0.25  # where a patch may have its middle
_STEP_PX = 4  # between the pixels that say which cells are seen
_MIN_SEEN = 4  # of those pixels
_SPEED = 2 * FALSE_A_FRAME / sum(LASTING_FRAMES)  # how many begin in a frame


class FalseMasks:
    """Patches that begin in one frame in thirty-odd and last 5 to 15; a function of (seed, frame in which one begins).

    A patch keeps its place in the world: of the cells of stuff that a frame shows it takes the one that comes first in
    its own order of all cells (rendezvous hashing), which is the same in the next frame unless that one went out of
    view or an earlier one came in. So no frame but the one at hand is looked at.
    """

    def __init__(self, seed: int = 0) -> None:
        self.seed = seed

    def of(self, things: VisibleThings) -> Iterator[tuple[BoolArray, str, list[int]]]:
        """Mask (H, W), class and key of each patch in the frame at hand."""
        names = sorted(set(things.frame.instance_classes.values()) - STUFF)
        index = things.frame.index
        for begin in range(index - LASTING_FRAMES[1] + 1, index + 1):
            # Frames before the first count too, so that the first sees as many as others.
            key = [self.seed, FALSE, begin + LASTING_FRAMES[1]]
            rng = np.random.default_rng(key)
            begins, lasts = rng.random() < _SPEED, int(rng.integers(LASTING_FRAMES[0], LASTING_FRAMES[1] + 1))
            if names and begins and index < begin + lasts:
                name = names[rng.integers(len(names))]
                mask = _patch(things, rng)
                if mask is not None:
                    yield mask, name, key


def _patch(things: VisibleThings, rng: np.random.Generator) -> BoolArray | None:
    """The pixels of stuff about the cell that comes first; None where the frame shows no stuff."""
    stuff = [thing for thing in things.boxes if things.is_stuff(thing)]
    on_stuff = np.isin(things.ids, stuff) & (things.frame.depth > 0)
    cells, seen = np.unique(
        np.floor(_points(things, *_every(_STEP_PX, on_stuff)) / _CELL_M).astype(np.int64), axis=0, return_counts=True
    )
    cells = cells[seen >= _MIN_SEEN]
    if not len(cells):
        return None
    first = cells[_hashed(cells, int(rng.integers(2**62))).argmin()]
    radius_m = rng.uniform(*RADIUS_M)
    rows, columns = np.nonzero(on_stuff)
    distance_m = np.linalg.norm(_points(things, rows, columns) - (first + 0.5) * _CELL_M, axis=1)
    mask = np.zeros_like(on_stuff)
    mask[rows, columns] = distance_m < radius_m
    return mask


def _every(step_px: int, mask: BoolArray) -> tuple[Int64Array, Int64Array]:
    rows, columns = np.nonzero(mask[::step_px, ::step_px])
    return rows * step_px, columns * step_px


def _points(things: VisibleThings, rows: Int64Array, columns: Int64Array) -> Float64Array:
    """Where pixels lie in the world, or in the camera of a frame without pose; (N, 3) metres."""
    frame = things.frame
    points = back_project(columns, rows, frame.depth[rows, columns], frame.intrinsics.matrix)
    return points if frame.world_from_camera is None else transform_points(frame.world_from_camera, points)


def _hashed(cells: Int64Array, key: int) -> np.ndarray:
    """A number for each cell (N, 3), as good as random, the same for the same key."""
    numbers = np.full(len(cells), key, np.uint64)
    for axis in cells.T.astype(np.uint64):
        # The finaliser of SplitMix64 (Steele, Lea and Flood 2014).
        numbers = (numbers ^ axis) * np.uint64(0xBF58476D1CE4E5B9)
        numbers = (numbers ^ (numbers >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        numbers ^= numbers >> np.uint64(31)
    return numbers
