"""Frame accounting while a run goes on: which frames were used, skipped with a reason, or lost."""

from __future__ import annotations

from bisect import bisect
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

from app.frames.frame_account import FrameAccount, SkippedFrame
from razer.arrays import Pose
from razer.errors import BadInput
from razer.frame import Frame
from slam.report import GraphReport


@dataclass(slots=True)
class FrameAccounting:
    """The account of one run over `planned` frames of the sequence `name`; given, the poses that frames used came with,
    by index; graph, the finished pose graph where poses were estimated to the end; pose_note, one line if that was done
    in another way in the end than while the run went on."""

    name: str
    planned: int
    max_bad: float
    stamps: list[float] = field(default_factory=list)
    poses: list[Pose] = field(default_factory=list)
    indices: list[int] = field(default_factory=list)
    skipped: list[SkippedFrame] = field(default_factory=list)
    lost: set[int] = field(default_factory=set)
    notes: Counter[str] = field(default_factory=Counter)
    interrupted: bool = False
    graph: GraphReport | None = None
    given: dict[int, Pose] = field(default_factory=dict)
    pose_note: str = ""

    @property
    def used(self) -> int:
        """How many frames went into the map."""
        return len(self.poses)

    def account(self) -> FrameAccount:
        """What became of the frames so far."""
        return FrameAccount.of(self.planned, self.indices, self.skipped, self.lost)

    def use(self, frame: Frame, given: Pose | None = None) -> None:
        """Count a posed frame that went into the map, be it later than its neighbours; `given`: the pose it came with,
        where another was estimated."""
        if given is not None:
            self.given[frame.index] = given
        self.lost.discard(frame.index)
        position = bisect(self.indices, frame.index)
        if position and frame.stamp <= self.stamps[position - 1]:
            self.notes["its stamp is not later than that of the frame used before it"] += 1
        self.stamps.insert(position, frame.stamp)
        self.poses.insert(position, frame.pose)
        self.indices.insert(position, frame.index)
        self.notes.update(frame.notes)

    def by_index(self) -> dict[int, Pose]:
        """The poses of frames used, by index."""
        return dict(zip(self.indices, self.poses, strict=True))

    def correct(self, corrections: Mapping[int, Pose | None]) -> None:
        """Replace poses by corrected ones, by frame index; frames used whose pose is None are lost after all."""
        corrected = [corrections.get(index, pose) for index, pose in zip(self.indices, self.poses, strict=True)]
        self.lost.update(index for index, pose in zip(self.indices, corrected, strict=True) if pose is None)
        still_posed = [row for row, pose in enumerate(corrected) if pose is not None]
        self.indices = [self.indices[row] for row in still_posed]
        self.stamps = [self.stamps[row] for row in still_posed]
        self.poses = [pose for pose in corrected if pose is not None]

    def skip(self, index: int, reason: str) -> None:
        """Count an unusable frame; raises BadInput once more than max_bad of all frames are."""
        self.lost.discard(index)
        self.skipped.append(SkippedFrame(index, reason))
        if len(self.skipped) > self.max_bad * self.planned:
            share = len(self.skipped) / self.planned
            hint = f"; repair them, or accept more with --max-bad {share:.2f} or higher" if self.used else ""
            raise BadInput(f"{self._unusable()}{hint}")

    def require_used(self) -> None:
        """Raise BadInput if nothing went into the map."""
        if not self.used and not self.interrupted:
            raise BadInput(
                self._unusable() if self.skipped else f"{self.name}: the camera could not be located in any frame"
            )

    def _unusable(self) -> str:
        first = self.skipped[0]
        return (
            f"{self.name}: {len(self.skipped)} of {self.planned} frames cannot be used, "
            f"first frame {first.frame}: {first.reason}"
        )
