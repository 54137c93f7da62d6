"""Sampling of a recording: a few frames in short overlapping stretches, shared by the checks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from data_tools.checks.camera_motion import Landmarks, Motion, find_landmarks, measure_motion
from data_tools.checks.pose_conventions import Convention
from data_tools.recordings.sequence import RgbdSequence
from razer.errors import UnusableFrame
from razer.frame import Frame

_STARTS, _OFFSETS = 6, (0, 1, 5, 16)


@dataclass
class Sample:
    """Usable frames with depth, those of one stretch together; motions between them are measured once."""

    groups: tuple[tuple[Frame, ...], ...]
    has_poses: bool
    _landmarks: dict[int, Landmarks] = field(default_factory=dict)
    _motions: dict[tuple[int, int], Motion | None] = field(default_factory=dict)

    @classmethod
    def of(cls, sequence: RgbdSequence) -> Sample:
        """About two dozen frames of a recording; broken ones are left out."""
        offsets = [offset for offset in _OFFSETS if offset <= len(sequence) // 2]
        starts = np.linspace(0, max(len(sequence) - 1 - offsets[-1], 0), _STARTS).astype(int)
        wanted = [[int(start) + offset for offset in offsets] for start in dict.fromkeys(starts.tolist())]
        read = {i: _frame_or_none(sequence, i) for i in dict.fromkeys(i for group in wanted for i in group)}
        groups = tuple(tuple(frame for i in group if (frame := read[i])) for group in wanted)
        return cls(groups, sequence.has_poses)

    @property
    def frames(self) -> list[Frame]:
        """All frames, each once."""
        return list({frame.index: frame for group in self.groups for frame in group}.values())

    def neighbours(self) -> Iterator[tuple[Frame, Frame]]:
        """Consecutive frames of each stretch, and its first and last."""
        for group in self.groups:
            yield from pairwise(group)
            if len(group) > 2:
                yield group[0], group[-1]

    def starts(self) -> list[tuple[Frame, Frame]]:
        """The first two frames of each stretch, which overlap most."""
        return [(group[0], group[1]) for group in self.groups if len(group) > 1]

    def motion(self, a: Frame, b: Frame) -> Motion | None:
        """The camera's motion between two frames as the images show it; None where too little agrees."""
        key = a.index, b.index
        if key not in self._motions:
            self._motions[key] = measure_motion(self._landmarks_of(a), self._landmarks_of(b), a.intrinsics)
        return self._motions[key]

    def reposed(self, convention: Convention) -> Sample:
        """The same frames with the poses that are meant by a convention."""
        meant = tuple(tuple(frame.at(convention.world_from_camera(frame.pose)) for frame in g) for g in self.groups)
        return replace(self, groups=meant)

    def _landmarks_of(self, frame: Frame) -> Landmarks:
        if frame.index not in self._landmarks:
            self._landmarks[frame.index] = find_landmarks(frame)
        return self._landmarks[frame.index]


def _frame_or_none(sequence: RgbdSequence, index: int) -> Frame | None:
    try:
        frame = sequence[index]
    except UnusableFrame:
        return None
    return frame if frame.depth.any() else None
