"""Input types of the method: pinhole intrinsics, posed RGB-D frames, and instance masks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from razer.arrays import BoolArray, Float32Array, Float64Array, Int32Array, IntArray, Uint8Array
from razer.errors import BadInput, UnusableFrame
from razer.geometry import is_rigid


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """A pinhole camera without distortion; pixel (0, 0) is the centre of the top left pixel."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise BadInput(f"an image of {self.width}x{self.height} pixels is impossible")
        if not (np.isfinite([self.fx, self.fy, self.cx, self.cy]).all() and self.fx > 0 and self.fy > 0):
            raise BadInput(f"focal lengths must be positive and finite, not {self.fx}, {self.fy}")

    @property
    def matrix(self) -> Float64Array:
        """The 3x3 camera matrix, float64."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]], dtype=np.float64)

    def resized(self, width: int, height: int) -> Intrinsics:
        """The same camera read out at another resolution."""
        sx, sy = width / self.width, height / self.height
        cx, cy = (self.cx + 0.5) * sx - 0.5, (self.cy + 0.5) * sy - 0.5
        return Intrinsics(width, height, self.fx * sx, self.fy * sy, cx, cy)


@dataclass(frozen=True, slots=True)
class RecordedColor:
    """The picture of a colour camera beside the depth camera, as it took it: rgb (h, w, 3) uint8; pixel (H, W) int32,
    where in it each pixel of the depth image lies, row by row."""

    rgb: Uint8Array
    pixel: Int32Array


@dataclass(frozen=True, slots=True)
class Frame:
    """One registered RGB-D image: colour and depth share one pixel grid.

    rgb (H, W, 3) uint8; depth (H, W) float32 metres along the optical axis, 0 = no reading;
    world_from_camera (4, 4) float64 with OpenCV axes (x right, y down, z forward), or None when
    unknown; instance_ids (H, W) int32, 0 = nobody, with instance_classes naming them, only where the
    source knows them (synthetic rooms, annotated data); notes say what a reader had to repair; has_color (H, W) bool
    is false where a colour camera beside the depth camera does not see what depth shows, None = everywhere true;
    part_ids (H, W) uint8 number the parts of each instance from 1, 0 = of no part, only where the source knows them;
    recorded_color, the picture that rgb was brought onto depth from, None where that is rgb itself; weight, how much
    its depth and colour count in the map, 1 = in full: less where its pose is uncertain.
    """

    index: int
    stamp: float
    rgb: Uint8Array
    depth: Float32Array
    intrinsics: Intrinsics
    world_from_camera: Float64Array | None = None
    instance_ids: Int32Array | None = None
    instance_classes: Mapping[int, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    has_color: BoolArray | None = None
    part_ids: Uint8Array | None = None
    recorded_color: RecordedColor | None = None
    weight: float = 1.0

    def __post_init__(self) -> None:
        shape = (self.intrinsics.height, self.intrinsics.width)
        if self.rgb.shape != (*shape, 3) or self.rgb.dtype != np.uint8:
            raise UnusableFrame(f"colour is {self.rgb.shape} {self.rgb.dtype}, expected {(*shape, 3)} uint8")
        if self.depth.shape != shape or self.depth.dtype != np.float32:
            raise UnusableFrame(f"depth is {self.depth.shape} {self.depth.dtype}, expected {shape} float32")
        if self.instance_ids is not None and self.instance_ids.shape != shape:
            raise UnusableFrame(f"instance ids are {self.instance_ids.shape}, expected {shape}")
        if self.has_color is not None and self.has_color.shape != shape:
            raise UnusableFrame(f"the pixels with colour are {self.has_color.shape}, expected {shape}")
        if self.part_ids is not None and self.part_ids.shape != shape:
            raise UnusableFrame(f"part ids are {self.part_ids.shape}, expected {shape}")
        if not 0 < self.weight <= 1:
            raise UnusableFrame(f"a weight of {self.weight} is impossible")
        if self.world_from_camera is not None and not is_rigid(self.world_from_camera):
            raise UnusableFrame("the pose is not a rigid transform")

    def at(self, world_from_camera: Float64Array) -> Frame:
        """The same images seen from the given pose."""
        return replace(self, world_from_camera=world_from_camera)

    @property
    def pose(self) -> Float64Array:
        """world_from_camera of a posed frame; raises UnusableFrame where there is none."""
        if self.world_from_camera is None:
            raise UnusableFrame("the frame has no pose: give one, or estimate it with slam.SlamSystem")
        return self.world_from_camera


@dataclass(frozen=True, slots=True)
class Masks:
    """N image masks: masks (N, H, W) bool, which may overlap; scores (N,) float32 in [0, 1];
    class_names, where the model classifies, one for each mask, '' = not known; stuff (N,) bool, where it knows what is
    counted: true for a piece of wall or floor, false for a thing."""

    masks: BoolArray
    scores: Float32Array
    class_names: tuple[str, ...] | None = None
    stuff: BoolArray | None = None

    def __post_init__(self) -> None:
        if self.masks.ndim != 3 or self.masks.dtype != np.bool_:
            raise ValueError(f"masks are {self.masks.shape} {self.masks.dtype}, expected (N, H, W) bool")
        if self.scores.shape != (len(self.masks),):
            raise ValueError(f"{len(self.masks)} masks but scores of shape {self.scores.shape}")
        if self.class_names is not None and len(self.class_names) != len(self.masks):
            raise ValueError(f"{len(self.masks)} masks but {len(self.class_names)} class names")
        if self.stuff is not None and (self.stuff.shape != (len(self.masks),) or self.stuff.dtype != np.bool_):
            raise ValueError(f"{len(self.masks)} masks but stuff of {self.stuff.shape} {self.stuff.dtype}")

    def __len__(self) -> int:
        return len(self.masks)

    @property
    def is_stuff(self) -> BoolArray:
        """Which masks (N,) are stuff; none where the model does not say."""
        return np.zeros(len(self), np.bool_) if self.stuff is None else self.stuff

    @classmethod
    def none(cls, height: int, width: int) -> Masks:
        """No masks on an image of the given size."""
        return cls(np.zeros((0, height, width), bool), np.zeros(0, np.float32))

    @classmethod
    def from_ids(cls, ids: IntArray) -> Masks:
        """One mask with score 1 for each positive id of an (H, W) image, in increasing order of id."""
        present = np.flatnonzero(np.bincount(ids.ravel().clip(0)))
        present = present[present > 0]
        return cls(ids[None] == present[:, None, None].astype(ids.dtype), np.ones(len(present), np.float32))

    def select(self, keep: IntArray | BoolArray) -> Masks:
        """The masks at the given indices, or where a boolean is true."""
        chosen = np.flatnonzero(keep) if keep.dtype == np.bool_ else keep
        names = None if self.class_names is None else tuple(self.class_names[i] for i in chosen)
        stuff = None if self.stuff is None else self.stuff[chosen]
        return Masks(self.masks[chosen], self.scores[chosen], names, stuff)
