"""Views, and those of them that are kept as keyframes."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, replace

import numpy as np

from razer.arrays import Float32Array, Float64Array
from razer.frame import Frame, Intrinsics
from slam.frontend.color_calibration import ColorCamera
from slam.frontend.depth_pyramid import SurfaceGrid, depth_pyramid, fine_depth, sparse_depth
from slam.frontend.features import FeatureExtractor, Features

CACHED_GRIDS = 64
STILL = np.zeros(3)


@dataclass(frozen=True)
class View:
    """What registration needs of a frame: its depth, reduced, its features, and how the camera turned, (3,) rad/s about
    its own axes; and a few of its readings, far ones among them, on the pixel grid of sparse_intrinsics."""

    index: int
    stamp: float
    turning_rad_s: Float64Array
    depth: Float32Array
    intrinsics: Intrinsics
    sparse_depth: Float32Array
    sparse_intrinsics: Intrinsics
    features: Features

    @classmethod
    def of(
        cls, frame: Frame, finder: FeatureExtractor, camera: ColorCamera, turning_rad_s: Float64Array = STILL
    ) -> View:
        """Reduce a frame."""
        depth, intrinsics = fine_depth(frame.depth, frame.intrinsics)
        sparse = sparse_depth(frame.depth, frame.intrinsics)
        return cls(frame.index, frame.stamp, turning_rad_s, depth, intrinsics, *sparse, finder.find(frame, camera))

    def turning(self, turning_rad_s: Float64Array) -> View:
        """The same view of a camera that turned otherwise."""
        return replace(self, turning_rad_s=turning_rad_s)

    def grids(self) -> tuple[SurfaceGrid, ...]:
        """Its oriented points, the coarsest grid first."""
        return depth_pyramid(self.depth, self.intrinsics)


@dataclass
class Keyframe:
    """A view that others are measured against: its number in the order of taking, the submap of the map it belongs to,
    its pose as known now, and how far the camera had travelled when it was taken, metres."""

    number: int
    submap: int
    view: View
    world_from_camera: Float64Array
    travelled_m: float


class Keyframes:
    """All keyframes; the points of those used last are kept at hand, the others are made again from their depth."""

    def __init__(self) -> None:
        self.all: list[Keyframe] = []
        self._grids: OrderedDict[int, tuple[SurfaceGrid, ...]] = OrderedDict()

    def __len__(self) -> int:
        return len(self.all)

    def __getitem__(self, number: int) -> Keyframe:
        return self.all[number]

    def add(
        self,
        view: View,
        grids: tuple[SurfaceGrid, ...],
        world_from_camera: Float64Array,
        submap: int,
        travelled_m: float,
    ) -> Keyframe:
        """Keep a view."""
        keyframe = Keyframe(len(self.all), submap, view, world_from_camera, travelled_m)
        self.all.append(keyframe)
        self._remember(keyframe.number, grids)
        return keyframe

    def grids(self, number: int) -> tuple[SurfaceGrid, ...]:
        """The oriented points of a keyframe."""
        if number in self._grids:
            self._grids.move_to_end(number)
            return self._grids[number]
        grids = self.all[number].view.grids()
        self._remember(number, grids)
        return grids

    def _remember(self, number: int, grids: tuple[SurfaceGrid, ...]) -> None:
        self._grids[number] = grids
        if len(self._grids) > CACHED_GRIDS:
            self._grids.popitem(last=False)

    def poses(self) -> Float64Array:
        """world_from_camera (K, 4, 4) of all of them."""
        return np.stack([keyframe.world_from_camera for keyframe in self.all])
