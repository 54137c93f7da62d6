"""Best-view selection: the frames that show an instance best."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from razer.arrays import IntArray

BEST_VIEWS = 3
# Frames nearer to each other than this show the same; the better one stands for both.
FRAMES_APART = 15
# What the image border cuts is visible in part.
CUT_FACTOR = 0.5
# Views that score much less than the best one add nothing.
MIN_RELATIVE_SCORE = 0.2


@dataclass(frozen=True, slots=True)
class Region:
    """What an image shows of something: box (x, y, width, height) and visible pixels; whole, whether the image border
    does not cut it."""

    box: tuple[int, int, int, int]
    pixels: int
    whole: bool

    @classmethod
    def of(cls, rows: IntArray, columns: IntArray, shape: tuple[int, ...], stride: int) -> Region:
        """The bounding region of depth readings.

        Args:
            rows: Rows (N,) of the readings in the strided image, N >= 1.
            columns: Their columns (N,).
            shape: Height and width of the strided image.
            stride: Every how many pixels of the full image were read.
        """
        top, bottom, left, right = (int(n) for n in (rows.min(), rows.max(), columns.min(), columns.max()))
        whole = top > 1 and left > 1 and bottom < shape[0] - 2 and right < shape[1] - 2
        box = (left * stride, top * stride, (right - left + 1) * stride, (bottom - top + 1) * stride)
        return cls(box, len(rows) * stride**2, whole)


@dataclass(frozen=True, slots=True)
class BestView:
    """A region of the frame with this index in the recording; stamp, its seconds where they are known."""

    frame: int
    region: Region
    stamp: float | None = None

    @property
    def score(self) -> float:
        """Visible pixels, less where the border cuts."""
        return self.region.pixels * (1.0 if self.region.whole else CUT_FACTOR)


def best_views(views: Iterable[BestView]) -> tuple[BestView, ...]:
    """At most BEST_VIEWS of them, FRAMES_APART from each other, the best first."""
    kept: list[BestView] = []
    for view in sorted(views, key=lambda v: (-v.score, v.frame)):
        if len(kept) == BEST_VIEWS or (kept and view.score < MIN_RELATIVE_SCORE * kept[0].score):
            break
        if all(abs(view.frame - other.frame) >= FRAMES_APART for other in kept):
            kept.append(view)
    return tuple(kept)
