"""Every n-th frame of a recording, with progress shown as they are read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from rich.console import Console

from app.console.progress import show_progress
from data_tools.recordings.sequence import FrameIteration, RgbdSequence
from razer.frame import Frame, Intrinsics


@dataclass(frozen=True)
class Selection(FrameIteration):
    """The frames `indices` of a sequence as a sequence of their own; reading them in order moves the progress."""

    sequence: RgbdSequence
    indices: range
    progress: Iterator[int] = field(repr=False)

    @classmethod
    def of(cls, sequence: RgbdSequence, stride: int, max_frames: int | None, console: Console) -> Selection:
        """Every stride-th frame of a recording.

        Args:
            sequence: the recording.
            stride: every how many frames one is selected.
            max_frames: how many at most; None = all.
            console: where progress is shown.
        """
        indices = range(0, len(sequence), stride)[:max_frames]
        return cls(sequence, indices, show_progress(indices, len(indices), lambda: "written", console))

    @property
    def name(self) -> str:
        """What to call the recording."""
        return self.sequence.name

    @property
    def intrinsics(self) -> Intrinsics:
        """The pinhole camera of every frame."""
        return self.sequence.intrinsics

    @property
    def has_poses(self) -> bool:
        """Whether frames come with world_from_camera."""
        return self.sequence.has_poses

    @property
    def depth_scale(self) -> float:
        """Declared depth units per metre of the files."""
        return self.sequence.depth_scale

    def __len__(self) -> int:
        return len(self.indices)

    def __getitem__(self, index: int) -> Frame:
        """The frame at `index` of the part; raises UnusableFrame with the reason, or IndexError past the end."""
        next(self.progress, None)
        return self.sequence[self.indices[index]]

    def finish(self) -> None:
        """Say that the last frame is done too."""
        for _ in self.progress:
            pass
