"""What of the true things a frame shows: where they are in the image, and from which side they are seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from razer.arrays import BoolArray, Int32Array, Uint8Array
from razer.errors import BadInput
from razer.frame import Frame

STUFF = frozenset({"wall", "floor", "ceiling"})
UNKNOWN = "unknown"
SECTORS = 6  # of 60 degrees each, round a thing

Window = tuple[slice, slice]
# What a generator is for: its second seed.
FOUND, NAMED, FALSE, PROPOSED, BLOBS, WARP, SEEN_AS, HIDDEN, SWALLOWED = range(10, 19)


@dataclass(frozen=True)
class VisibleThings:
    """The instances that a frame shows, from its instance ids."""

    frame: Frame
    ids: Int32Array

    @classmethod
    def of(cls, frame: Frame, asked_by: str) -> VisibleThings:
        """Those of a frame; raises BadInput, naming the model that asked, where the frame has no instance ids."""
        if frame.instance_ids is None:
            raise BadInput(
                f"frame {frame.index} has no instance ids, which the oracle {asked_by} needs: "
                "use a recording with ids/ (ScanNet: instance-filt/), or --segmenter geometric"
            )
        return cls(frame, frame.instance_ids)

    @cached_property
    def boxes(self) -> dict[int, Window]:
        """The window of the image round each thing."""
        from scipy import ndimage  # late: a map of these masks is asked without

        return {i: box for i, box in enumerate(ndimage.find_objects(self.ids.clip(0)), start=1) if box is not None}

    def name(self, thing: int) -> str:
        """Its class, "unknown" where the recording does not say."""
        return self.frame.instance_classes.get(thing, UNKNOWN)

    def is_stuff(self, thing: int) -> bool:
        """Whether it is wall, floor or ceiling."""
        return self.name(thing) in STUFF

    def area_px(self, thing: int) -> int:
        """How many pixels show it."""
        return int(np.count_nonzero(self.ids[self.boxes[thing]] == thing))

    def is_cut(self, thing: int) -> bool:
        """Whether it reaches the border of the image."""
        rows, columns = self.boxes[thing]
        height, width = self.ids.shape
        return rows.start == 0 or columns.start == 0 or rows.stop == height or columns.stop == width

    def mask(self, thing: int, window: Window) -> BoolArray:
        """Its pixels in a window of the image."""
        return self.ids[window] == thing

    def parts(self, window: Window) -> Uint8Array | None:
        """The numbers of parts in a window; None where the recording knows none."""
        return None if self.frame.part_ids is None else self.frame.part_ids[window]

    def sector(self, thing: int, start_deg: float = 0.0) -> int:
        """From which of six sectors of 60 degrees about the world's z the camera looks at it: by the ray through the
        middle of its pixels, the first sector beginning at `start_deg`."""
        rows, columns = np.nonzero(self.mask(thing, self.boxes[thing]))
        box, camera = self.boxes[thing], self.frame.intrinsics
        ray = np.array(
            [
                (columns.mean() + box[1].start - camera.cx) / camera.fx,
                (rows.mean() + box[0].start - camera.cy) / camera.fy,
                1.0,
            ]
        )
        pose = self.frame.world_from_camera
        x, y, _ = ray if pose is None else pose[:3, :3] @ ray
        return int((np.degrees(np.arctan2(y, x)) - start_deg) % 360 // (360 / SECTORS))

    def shares(self, mask: BoolArray, window: Window = (slice(None), slice(None))) -> dict[int, float]:
        """The share of a mask's pixels in a window that each thing has, of those of any thing; in order of id."""
        counts = np.bincount(self.ids[window][mask].clip(0))
        counts[:1] = 0
        return {thing: float(counts[thing] / counts.sum()) for thing in np.flatnonzero(counts).tolist()}


def largest(shares: Mapping[int, float]) -> int:
    """The thing with the largest share, the first of several; 0 where there is none."""
    return max(shares, key=lambda thing: shares[thing], default=0)


def smooth_noise(shape: tuple[int, int], spacing_px: int, rng: np.random.Generator) -> np.ndarray:
    """A smooth random field (H, W) float32 of standard normal values: knots `spacing_px` apart, linear between."""
    (row, along_rows), (column, along_columns) = (_knots(length, spacing_px) for length in shape)
    knots = rng.standard_normal((row[-1] + 2, column[-1] + 2)).astype(np.float32)
    between_rows = knots[row] * (1 - along_rows)[:, None] + knots[row + 1] * along_rows[:, None]
    field = between_rows[:, column] * (1 - along_columns) + between_rows[:, column + 1] * along_columns
    # Means of knots vary less than knots do.
    spread = [np.sqrt(t**2 + (1 - t) ** 2) for t in (along_rows, along_columns)]
    return field / (spread[0][:, None] * spread[1])


def _knots(length: int, spacing_px: int) -> tuple[np.ndarray, np.ndarray]:
    """For each pixel the knot before it, and how far it is on the way to the next."""
    place = np.arange(length) / spacing_px
    return place.astype(np.intp), (place % 1).astype(np.float32)
