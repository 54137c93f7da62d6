"""Sampled views of a recording for RGB-D calibration: rims, edges and image flow of frames spread over it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from data_tools.calibration.color_edges import ColorEdges
from data_tools.calibration.depth_rims import find_depth_rims
from data_tools.calibration.edge_registration import RimView
from data_tools.recordings.sequence import RgbdSequence
from razer.arrays import Float32Array, Float64Array
from razer.errors import UnusableFrame
from razer.frame import Frame, Intrinsics

N_VIEWS = 60  # frames; with 40 what is planted on 60 frames of a fast turn came out 2.3 pixels off, with 60 it is 1.7
_FLOW_SIZE = (160, 120)
_FLOW_DECIMALS = 6
_MIN_RESPONSE = 0.05  # of phase correlation; weaker peaks are chance
_DEPTHS = (0.1, 0.5, 0.9)  # quantiles of the readings


@dataclass(frozen=True)
class SampledViews:
    """Views spread over a recording, the near, median and far depths (3,) of what they show, metres, and how many
    images of new content they hold: views of the same things err alike."""

    views: tuple[RimView, ...]
    depths_m: Float64Array
    n_independent: float = float(N_VIEWS)

    @classmethod
    def of(cls, sequence: RgbdSequence) -> SampledViews:
        """About N_VIEWS views; frames that cannot be used are left out."""
        views, depths, indices = [], [], []
        for index in dict.fromkeys(np.linspace(0, len(sequence) - 1, N_VIEWS).round().astype(int).tolist()):
            frame = _frame_or_none(sequence, index)
            if frame is None:
                continue
            views.append(RimView(find_depth_rims(frame), ColorEdges.of(frame.rgb), _flow_px(sequence, index, frame)))
            readings = frame.depth[::8, ::8]
            depths.append(readings[readings > 0])
            indices.append(index)
        readings = np.concatenate(depths) if depths else np.zeros(0, np.float32)
        quantiles = np.quantile(readings, _DEPTHS) if len(readings) else np.ones(len(_DEPTHS))
        return cls(tuple(views), quantiles.astype(np.float64), _independent(views, indices, sequence.intrinsics))


def _independent(views: Sequence[RimView], indices: Sequence[int], camera: Intrinsics) -> float:
    """How many images of new content views hold: from one to the next the image flows on for so many frames, and what
    has flowed in is new, all of it where frames are so far apart that this cannot be told."""
    new = 1.0
    for view, gap in zip(views[:-1], np.diff(indices), strict=True):
        new += min(1.0, float(np.linalg.norm(view.flow_px / (camera.width, camera.height))) * float(gap))
    return new


def _flow_px(sequence: RgbdSequence, index: int, frame: Frame) -> Float64Array:
    """How the image moves (2,) from a frame to the next, pixels, by phase correlation; 0 where it cannot be told."""
    following = _frame_or_none(sequence, index + 1)
    if following is None:
        return np.zeros(2)
    window = cv2.createHanningWindow(_FLOW_SIZE, cv2.CV_32F)
    (dx, dy), response = cv2.phaseCorrelate(_small(frame), _small(following), window)
    if response < _MIN_RESPONSE:
        return np.zeros(2)
    height, width = frame.depth.shape
    # Equal images are found to move by rounding errors.
    return np.array([dx * width / _FLOW_SIZE[0], dy * height / _FLOW_SIZE[1]]).round(_FLOW_DECIMALS)


def _small(frame: Frame) -> Float32Array:
    grey = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY)
    return cv2.resize(grey, _FLOW_SIZE, interpolation=cv2.INTER_AREA).astype(np.float32)


def _frame_or_none(sequence: RgbdSequence, index: int) -> Frame | None:
    try:
        return sequence[index]
    except (UnusableFrame, IndexError):
        return None
