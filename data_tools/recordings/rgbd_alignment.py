"""RGB-D alignment: colour and depth on one undistorted pixel grid, that of the depth image."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from data_tools.recordings.camera import HOW_TO_DECLARE, Camera, Declared
from data_tools.recordings.color_warp import ColorWarp
from data_tools.recordings.rgbd_calibration import RgbdCalibration
from razer.arrays import BoolArray, Float32Array, Float64Array, Int16Array, Uint8Array, Uint16Array
from razer.errors import BadInput
from razer.frame import Intrinsics, RecordedColor

Size = tuple[int, int]
"""(width, height) in pixels."""
_SAME_RAYS = 0.01  # share of the image size by which two calibrations of one camera may differ


@dataclass(frozen=True)
class PixelMap:
    """Where each pixel of an undistorted image comes from, in OpenCV's fixed-point form."""

    xy: Int16Array
    fraction: Uint16Array

    @classmethod
    def undistorting(cls, camera: Camera, source: Intrinsics, target: Intrinsics) -> PixelMap:
        """From the distorted image of `camera` with `source` intrinsics to the pinhole `target`."""
        xy, fraction = cv2.initUndistortRectifyMap(
            source.matrix,
            np.array(camera.distortion or [0.0] * 5),
            None,
            target.matrix,
            (target.width, target.height),
            cv2.CV_16SC2,
        )
        return cls(xy, fraction)

    def smooth(self, image: Uint8Array) -> Uint8Array:
        """Colours, interpolated between pixels; black outside."""
        return cv2.remap(image, self.xy, self.fraction, cv2.INTER_LINEAR)

    def nearest(self, image: NDArray) -> NDArray:
        """Depths or ids, never mixed between neighbours; 0 outside."""
        return cv2.remap(image, self.xy, self.fraction, cv2.INTER_NEAREST)


@dataclass(frozen=True)
class RgbdAlignment:
    """How raw images of known sizes become a colour and a depth image on the pinhole grid `intrinsics`;
    color_from_depth (4, 4), where a second camera took colour."""

    intrinsics: Intrinsics
    color_size: Size
    depth_size: Size
    color_map: PixelMap | None = None
    depth_map: PixelMap | None = None
    warp: ColorWarp | None = None
    color_from_depth: Float64Array | None = None

    @property
    def is_plain(self) -> bool:
        """Whether images are used as they were recorded, whatever the intrinsics are."""
        maps = (self.color_map, self.depth_map, self.warp)
        return self.color_size == self.depth_size and all(each is None for each in maps)

    def color(self, rgb: Uint8Array, depth: Float32Array) -> tuple[Uint8Array, BoolArray | None, RecordedColor | None]:
        """Colour on the grid of the aligned `depth`, which pixels have one, None = all, and the picture that it was
        looked up in, None = this one."""
        if self.warp is None and self.color_size != self.depth_size:
            shrinks = self.color_size[0] > self.depth_size[0]
            rgb = cv2.resize(rgb, self.depth_size, interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR)
        if self.color_map is not None:
            rgb = self.color_map.smooth(rgb)
        if self.warp is None:
            return rgb, None, None
        registered = self.warp.apply(rgb, depth)
        return registered.rgb, registered.is_seen, registered.recorded

    def on_depth_grid(self, image: NDArray) -> NDArray:
        """A depth or id image of the depth camera, undistorted."""
        return image if self.depth_map is None else self.depth_map.nearest(image)


def make_rgbd_alignment(declared: Declared, color_size: Size, depth_size: Size) -> RgbdAlignment:
    """The alignment that follows from what is declared; raises BadInput when it does not follow."""
    if (depth_camera := declared.depth_camera) is None:
        raise BadInput(f"the camera is unknown: give {HOW_TO_DECLARE}")
    target = _depth_grid(depth_camera, depth_size, color_size)
    depth_map = _undistortion(depth_camera, target, target)
    if declared.color_from_depth is not None:
        camera, pinhole = _color_camera(declared, color_size, depth_size)
        warp = ColorWarp.between(target, RgbdCalibration(pinhole, declared.color_from_depth))
        color_map = _undistortion(camera, pinhole, pinhole)
        return RgbdAlignment(target, color_size, depth_size, color_map, depth_map, warp, declared.color_from_depth)
    camera = _shared_rays(declared, color_size, depth_size)
    # The colour image is first resized to the depth grid, so its camera is taken at that size.
    source = camera.at(color_size).resized(*depth_size) if camera is not depth_camera else target
    color_map = _undistortion(camera, source, target)
    return RgbdAlignment(target, color_size, depth_size, color_map, depth_map)


def _depth_grid(camera: Camera, depth_size: Size, color_size: Size) -> Intrinsics:
    if camera.size not in (None, depth_size, color_size):
        raise BadInput(
            f"the intrinsics are for {_text(camera.size)} images but depth is {_text(depth_size)} "
            f"and colour {_text(color_size)}: correct width and height"
        )
    return camera.at(depth_size)


def _undistortion(camera: Camera, source: Intrinsics, target: Intrinsics) -> PixelMap | None:
    if not any(camera.distortion) and source == target:
        return None
    return PixelMap.undistorting(camera, source, target)


def _color_camera(declared: Declared, color_size: Size, depth_size: Size) -> tuple[Camera, Intrinsics]:
    """The colour camera of an unregistered pair; one camera declared for both must fit both sizes."""
    if declared.color_camera is not None:
        return declared.color_camera, declared.color_camera.at(color_size)
    assert declared.depth_camera is not None
    if not _same_aspect(color_size, depth_size):
        raise BadInput(
            f"colour is {_text(color_size)} and depth {_text(depth_size)}, and only one camera is declared: "
            'give --intrinsics FILE.json with a "color" camera beside the depth camera'
        )
    return declared.depth_camera, declared.depth_camera.at(depth_size).resized(*color_size)


def _shared_rays(declared: Declared, color_size: Size, depth_size: Size) -> Camera:
    """The camera of a colour image that shares its rays with depth, up to resolution."""
    depth_camera, color_camera = declared.depth_camera, declared.color_camera
    assert depth_camera is not None
    if color_camera is not None:
        own, other = color_camera.at(color_size).resized(*depth_size), depth_camera.at(depth_size)
        tolerance = _SAME_RAYS * max(depth_size)
        if np.abs(own.matrix - other.matrix).max() <= tolerance:
            return color_camera
        raise BadInput(
            "colour and depth come from two different cameras: give --depth-to-color FILE with the 4x4 "
            "matrix from the one to the other"
        )
    if color_size == depth_size or (depth_camera.size and _same_aspect(color_size, depth_size)):
        return depth_camera
    raise BadInput(
        f"colour is {_text(color_size)} but depth {_text(depth_size)} and their relation is unknown: give "
        "--depth-to-color FILE, or --intrinsics FILE.json with width and height if they are registered"
    )


def _same_aspect(a: Size, b: Size) -> bool:
    return a[0] * b[1] == a[1] * b[0]


def _text(size: Size | None) -> str:
    return "unknown" if size is None else f"{size[0]}x{size[1]}"
