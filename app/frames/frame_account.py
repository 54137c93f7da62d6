"""The account of a run's frames: one type and one JSON shape for every verb that speaks of frames."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any


@dataclass(frozen=True, slots=True)
class SkippedFrame:
    """A frame that could not be used, and why in one plain line."""

    frame: int
    reason: str


@dataclass(frozen=True, slots=True)
class FrameAccount:
    """What became of the `asked` frames that start, end, stride and max_frames choose: `frames` of them came (all,
    unless the run was cut short), of which `used` have a pose in the trajectory, others were skipped with a reason, and
    `lost` could not be located, in intervals (first, last) with no frame used between.

    Of a run folder that keeps no account, or one that contradicts its trajectory, only what is known for certain: the
    rest is None."""

    used: int
    asked: int | None = None
    frames: int | None = None
    skipped: tuple[SkippedFrame, ...] | None = None
    lost: int | None = None
    lost_intervals: tuple[tuple[int, int], ...] | None = None

    @classmethod
    def of(
        cls, asked: int, used: Sequence[int], skipped: Sequence[SkippedFrame], lost: Collection[int]
    ) -> FrameAccount:
        """The account of frames by index.

        Args:
            asked: how many frames were asked for.
            used: those with a pose, ascending.
            skipped: those that could not be used.
            lost: those that came and could not be located.
        """
        came = len(used) + len(skipped) + len(lost)
        return cls(len(used), asked, came, tuple(skipped), len(lost), _intervals(lost, used))

    @property
    def tracked(self) -> float | None:
        """The share of the frames asked for that were used; None where it is not known."""
        return self.used / self.asked if self.asked else None

    def describe(self) -> str:
        """The account in one plain clause, without what is not known."""
        came = "" if self.frames is None else f" of {self.frames}"
        lost = f", {self.lost} lost" if self.lost else ""
        skipped = f", {len(self.skipped)} skipped" if self.skipped else ""
        asked = f"; {self.asked} were asked for" if self.asked not in (None, self.frames) else ""
        return f"{self.used}{came} frames used{lost}{skipped}{asked}"

    def as_json(self) -> dict[str, Any]:
        """The shape that every verb prints, null for what is not known."""
        skipped = None if self.skipped is None else [{"frame": s.frame, "reason": s.reason} for s in self.skipped]
        return {
            "frames": self.frames,
            "used": self.used,
            "skipped": skipped,
            "lost": self.lost,
            "lost_intervals": None if self.lost_intervals is None else [list(one) for one in self.lost_intervals],
            "tracked": self.tracked,
            "asked": self.asked,
        }

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> FrameAccount:
        """What as_json wrote; raises KeyError, TypeError or ValueError for anything else."""
        return cls(
            used=int(content["used"]),
            asked=int(content["asked"]),
            frames=int(content["frames"]),
            skipped=tuple(SkippedFrame(int(one["frame"]), str(one["reason"])) for one in content["skipped"]),
            lost=int(content["lost"]),
            lost_intervals=tuple((int(first), int(last)) for first, last in content["lost_intervals"]),
        )


def _intervals(lost: Collection[int], used: Sequence[int]) -> tuple[tuple[int, int], ...]:
    """First and last of each run of lost frames with none used between."""
    runs = [list(run) for _, run in groupby(sorted(lost), key=lambda index: bisect(used, index))]
    return tuple((run[0], run[-1]) for run in runs)
