"""Recordings spoilt on purpose, frame by frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np

from razer.arrays import Float64Array
from razer.frame import Frame, Intrinsics


@dataclass
class Spoilt:
    """A recording whose frames are changed one by one, all read once."""

    frames: list[Frame]
    change: Callable[[Frame], Frame]
    depth_scale: float = 1000.0
    has_poses: bool = True
    name: str = "spoilt"

    @property
    def intrinsics(self) -> Intrinsics:
        return self.frames[0].intrinsics

    def __len__(self) -> int:
        return len(self.frames)

    def __getitem__(self, index: int) -> Frame:
        return self.change(self.frames[index])


def as_is(frame: Frame) -> Frame:
    return frame


def posed(change: Callable[[Float64Array], Float64Array]) -> Callable[[Frame], Frame]:
    return lambda frame: frame.at(change(frame.pose))


def scaled(factor: float) -> Callable[[Frame], Frame]:
    return lambda frame: replace(frame, depth=frame.depth * np.float32(factor))


def depth_moved(zoom: float, shift_px: tuple[float, float]) -> Callable[[Frame], Frame]:
    """Depth as another camera would have it, that stands in the same place."""

    def move(frame: Frame) -> Frame:
        height, width = frame.depth.shape
        x, y = (1 - zoom) * (width - 1) / 2 + shift_px[0], (1 - zoom) * (height - 1) / 2 + shift_px[1]
        matrix = np.array([[zoom, 0, x], [0, zoom, y]])
        return replace(frame, depth=cv2.warpAffine(frame.depth, matrix, (width, height), flags=cv2.INTER_NEAREST))

    return move


def mirrored(frame: Frame) -> Frame:
    return replace(frame, rgb=np.ascontiguousarray(frame.rgb[:, ::-1]))
