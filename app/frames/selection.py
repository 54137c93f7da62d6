"""The frames of a recording that settings choose, and a recording of them alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from rich.console import Console

from app.console.progress import show_progress
from app.settings.run_config import InputSettings
from data_tools.recordings.sequence import FrameIteration, RgbdSequence
from razer.errors import BadInput
from razer.frame import Frame, Intrinsics


def selected_frames(sequence: RgbdSequence, settings: InputSettings) -> range:
    """The indices of the frames that start, end, stride and max_frames choose; raises BadInput where start lies past
    the end of the recording."""
    if settings.start and settings.start >= len(sequence):
        last = len(sequence) - 1
        raise BadInput(f"{sequence.name} has frames 0 to {last}: --start {settings.start} lies past its end")
    end = len(sequence) if settings.end is None else min(settings.end, len(sequence))
    return range(settings.start, end, settings.stride)[: settings.max_frames]


@dataclass(frozen=True)
class Selection(FrameIteration):
    """The frames `indices` of a sequence as a sequence of their own; reading them in order moves the progress."""

    sequence: RgbdSequence
    indices: range
    progress: Iterator[int] = field(repr=False)

    @classmethod
    def of(cls, sequence: RgbdSequence, indices: range, console: Console) -> Selection:
        """The frames `indices` of a recording, with progress shown on a console."""
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
