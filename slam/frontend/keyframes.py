"""Views of frames, and those of them that are kept as keyframes."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np

from razer.arrays import BoolArray, Float64Array, IndexArray, Int64Array
from razer.frame import Frame, Intrinsics
from slam.config import SlamConfig
from slam.frontend.color_calibration import ColorCalibration
from slam.frontend.depth_pyramid import DepthPyramid, fine_depth
from slam.frontend.features import Features
from slam.frontend.sparse_readings import MOVED_PIXELS, SparseReadings
from slam.frontend.wide_features import WideFeatures

KEPT_PYRAMIDS = 32  # about 1 MB each; the keyframes round about are asked for again and again, the others seldom
STILL = np.zeros(3)
MIN_POINTS = 500  # of the depth of a keyframe: else nothing follows it


@dataclass(frozen=True)
class View:
    """What registration needs of a frame: its depth pyramid, its features, and how the camera turned, (3,) rad/s about
    its own axes; a few of its readings, far ones among them, with their colours; and features that match from afar."""

    index: int
    stamp: float
    turning_rad_s: Float64Array
    pyramid: DepthPyramid
    sparse: SparseReadings
    features: Features
    wide: WideFeatures

    @classmethod
    def of(
        cls,
        frame: Frame,
        features: Features,
        turning_rad_s: Float64Array,
        config: SlamConfig,
        calibration: ColorCalibration | None = None,
    ) -> View:
        """Reduce a frame to what registration needs.

        Args:
            frame: colour and depth; its pose is not used.
            features: those of the frame.
            turning_rad_s: (3,) how the camera turns about its own axes, as far as known.
            config: how far depth is used, and how much of it for the free-space check.
            calibration: the colour camera as known so far, None = nominal.
        """
        pyramid = DepthPyramid(*fine_depth(frame.depth, frame.intrinsics, config.depth.max_depth_m))
        calibration = calibration or ColorCalibration.nominal()
        sparse = SparseReadings.of(frame, config.free_space.image_width, calibration)
        wide = WideFeatures(frame, calibration, config)
        return cls(frame.index, frame.stamp, turning_rad_s, pyramid, sparse, features, wide)

    @cached_property
    def median_depth_m(self) -> float:
        """Of its readings; 1 where there are none."""
        read = self.sparse.depth[self.sparse.depth > 0].astype(np.float32)
        return float(np.median(read)) if len(read) else 1.0

    def recolored(self, calibration: ColorCalibration) -> View:
        """The same view, its colours registered to its depth as a colour camera is known now."""
        return replace(self, sparse=self.sparse.recolored(calibration))

    def turning(self, turning_rad_s: Float64Array) -> View:
        """The same view of a camera that turned otherwise; the pyramid is shared."""
        return replace(self, turning_rad_s=turning_rad_s)

    def without(self, pixels: BoolArray) -> View:
        """The same view without what it shows at some pixels (h, w) of the grid of its sparse readings."""
        k = self.pyramid.intrinsics
        fine = cv2.resize(pixels.astype(np.uint8), (k.width, k.height), interpolation=cv2.INTER_NEAREST) > 0
        features = self.features.select(~_at(self.features, fine, k))
        wide = self.wide.select(~_at(self.wide.features, fine, k))
        sparse = self.sparse.without(pixels)
        return replace(self, pyramid=self.pyramid.without(fine), sparse=sparse, features=features, wide=wide)


def _at(features: Features, pixels: BoolArray, k: Intrinsics) -> BoolArray:
    """Which features (N,) lie on pixels (H, W) of a camera; those outside of its image do not."""
    column, row = np.rint(features.rays * (k.fx, k.fy) + (k.cx, k.cy)).astype(int).T
    inside = (column >= 0) & (column < k.width) & (row >= 0) & (row < k.height)
    return inside & pixels[row.clip(0, k.height - 1), column.clip(0, k.width - 1)]


@dataclass
class Keyframe:
    """A view that others are registered to: its number in the order of taking, the submap it belongs to, its pose as
    known now, how far the camera had travelled when it was taken, metres, and the odometry chain it belongs to: the
    number of times that tracking began anew."""

    number: int
    submap: int
    view: View
    world_from_camera: Float64Array
    travelled_m: float
    chain: int = 0


@dataclass(frozen=True)
class LocatedView:
    """A view, and where it lies in front of a keyframe."""

    view: View
    reference: Keyframe
    reference_from_camera: Float64Array


class Keyframes:
    """All keyframes; the depth pyramids of those used last are kept, the others are made again from their depth."""

    def __init__(self) -> None:
        self.all: list[Keyframe] = []
        self._kept: OrderedDict[int, DepthPyramid] = OrderedDict()
        self._calibration = ColorCalibration.nominal()  # by which their colours are where they are
        self._poses = np.zeros((64, 4, 4))
        self._stacked: list[Float64Array] = []  # the keyframes' poses that are in _poses

    def __len__(self) -> int:
        return len(self.all)

    def __getitem__(self, number: int) -> Keyframe:
        return self.all[number]

    def add(
        self, view: View, world_from_camera: Float64Array, submap: int, travelled_m: float, chain: int = 0
    ) -> Keyframe:
        """Keep a view.

        Args:
            view: the view.
            world_from_camera: (4, 4) its pose as known now.
            submap: the submap it belongs to.
            travelled_m: how far the camera has travelled, metres.
            chain: the odometry chain it belongs to.
        """
        keyframe = Keyframe(len(self.all), submap, view, world_from_camera, travelled_m, chain)
        self.all.append(keyframe)
        self.view(keyframe)
        return keyframe

    def view(self, keyframe: Keyframe) -> View:
        """The view of a keyframe, to be registered: its pyramid is now the one that was used last."""
        self._kept[keyframe.number] = keyframe.view.pyramid
        self._kept.move_to_end(keyframe.number)
        if len(self._kept) > KEPT_PYRAMIDS:
            _, unused = self._kept.popitem(last=False)
            unused.release()
        return keyframe.view

    def recolor(self, calibration: ColorCalibration) -> None:
        """Register the colours of all views to their depth as the colour camera is known now, if that moves them."""
        if not self.all or not self._has_moved(self.all[-1].view, calibration):
            return
        self._calibration = calibration
        for keyframe in self.all:
            keyframe.view = keyframe.view.recolored(calibration)

    def _has_moved(self, view: View, calibration: ColorCalibration) -> bool:
        before, now = (view.sparse.color_offsets(each) for each in (self._calibration, calibration))
        return bool(np.abs(now - before).max() > MOVED_PIXELS)

    def poses(self) -> Float64Array:
        """world_from_camera (K, 4, 4) of all of them, to be read only; those that changed since are put in."""
        while len(self._poses) < len(self.all):
            self._poses = np.concatenate([self._poses, np.zeros_like(self._poses)])
        known = len(self._stacked)
        changed = [n for n, pose in enumerate(self._stacked) if self.all[n].world_from_camera is not pose]
        for n in (*changed, *range(known, len(self.all))):
            self._poses[n] = self.all[n].world_from_camera
            self._stacked[n : n + 1] = [self.all[n].world_from_camera]
        return self._poses[: len(self.all)]

    def submaps(self) -> Int64Array:
        """The submap (K,) of each."""
        return np.array([keyframe.submap for keyframe in self.all], np.int64)

    def of_submap(self, submap: int) -> IndexArray:
        """The numbers of those of a submap, in order."""
        return np.flatnonzero(self.submaps() == submap)

    def chains(self) -> Int64Array:
        """The odometry chain (K,) of each."""
        return np.array([keyframe.chain for keyframe in self.all], np.int64)
