"""Sensor model of an RGB-D camera with the errors of a Kinect; each error can be left out."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from data_tools.synthetic.camera import color_errors as colour_errors
from data_tools.synthetic.camera import depth_errors
from razer.arrays import Float32Array, Float64Array, Uint8Array
from razer.errors import BadInput
from razer.frame import Intrinsics

_KINECT_STEP_PER_M = 1 / (8 * 580 * 0.075)  # disparity in 1/8 pixel, focal length in pixels, baseline in metres
_SHARES = ("edge_dropout", "grazing_dropout", "exposure_drift", "shutter")


@dataclass(frozen=True, slots=True)
class SensorModel:
    """How strong each error is; all are absent unless given. Raises BadInput for what no sensor can be."""

    axial_noise: float = 0.0
    """Noise along the optical axis, times depth_errors.axial_sigma_m (Nguyen et al. 2012); 1 = a Kinect's."""
    lateral_noise_px: float = 0.0
    """Deviation across the image, in pixels of depth; 0.8 in the same paper."""
    disparity_step_per_m: float = 0.0
    """The step of inverse depth, 1 / (8 f b), which makes steps of dz = z^2 / (8 f b) in depth."""
    depth_step_m: float = 0.0
    """The unit of the depth image, metres."""
    edge_dropout: float = 0.0
    """Share of the readings lost where depth jumps."""
    grazing_dropout: float = 0.0
    """Share of the readings lost on surfaces seen edge-on; fewer at the angles of depth_errors.GRAZING_DEG."""
    range_m: tuple[float, float] = (0.0, math.inf)
    """Least and most depth that is read, metres."""
    colour_noise: float = 0.0
    """Deviation of each channel of each pixel, grey levels."""
    exposure_drift: float = 0.0
    """Largest share by which brightness slowly rises and falls along a recording."""
    shutter: float = 0.0
    """Share of the time between two frames at 15 a second in which the camera's rotation blurs colour."""
    misregistration_px: float = 0.0
    """By how far colour is shifted against depth, pixels; the direction slowly turns."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name != "range_m" and not 0 <= value < (1.0000001 if field.name in _SHARES else math.inf):
                raise BadInput(f"the sensor's {field.name} of {value} is impossible")
        if not 0 <= self.range_m[0] < self.range_m[1]:
            raise BadInput(f"the sensor's range of {self.range_m[0]} to {self.range_m[1]} m is empty")

    @classmethod
    def none(cls) -> SensorModel:
        """A sensor without error."""
        return cls()

    @classmethod
    def plain(cls) -> SensorModel:
        """Noise, whole millimetres and readings lost along edges, in exact registration."""
        return cls(axial_noise=1.0, depth_step_m=0.001, edge_dropout=0.5, colour_noise=2.5)

    @classmethod
    def kinect(cls) -> SensorModel:
        """Every error, as strong as a Kinect's in the hand."""
        return cls(
            axial_noise=1.0,
            lateral_noise_px=0.8,
            disparity_step_per_m=_KINECT_STEP_PER_M,
            depth_step_m=0.001,
            edge_dropout=0.5,
            grazing_dropout=1.0,
            range_m=(0.4, 5.0),
            colour_noise=2.5,
            exposure_drift=0.15,
            shutter=0.2,
            misregistration_px=1.5,
        )

    def observe(
        self,
        rgb: Uint8Array,
        depth: Float32Array,
        camera: Intrinsics,
        poses: Float64Array,
        *,
        index: int,
        seed: int,
        before: Float64Array | None = None,
    ) -> tuple[Uint8Array, Float32Array]:
        """What the sensor makes of a true colour and depth image; always the same for the same arguments.

        Args:
            rgb: (H, W, 3) uint8, the true colour.
            depth: (H, W) float32 metres, the true depth.
            camera: of both.
            poses: (N, 4, 4) of the recording; only this frame's and the one before matter.
            index: the frame.
            seed: of the recording.
            before: the pose (4, 4) from which on the camera's rotation blurs, by the share `shutter`; None = that of
                the frame before.
        """
        rng = np.random.default_rng([seed, 3, index])
        flow = colour_errors.blur_px(poses, index, camera, self.shutter, before)
        return self._colour(rgb, flow, index, seed, rng), self._depth(depth, camera, rng)

    def _colour(
        self, rgb: Uint8Array, flow: Float64Array, index: int, seed: int, rng: np.random.Generator
    ) -> Uint8Array:
        if self.shutter or self.misregistration_px:
            offset = colour_errors.rolling_offset_px(self.misregistration_px, seed, index)
            rgb = colour_errors.smear(rgb, flow, offset)
        if self.exposure_drift:
            rgb = colour_errors.expose(rgb, colour_errors.exposure(self.exposure_drift, seed, index))
        return colour_errors.add_noise(rgb, self.colour_noise, rng) if self.colour_noise else rgb

    def _depth(self, true: Float32Array, camera: Intrinsics, rng: np.random.Generator) -> Float32Array:
        depth = true
        if self.lateral_noise_px:
            depth = depth_errors.add_lateral_noise(depth, self.lateral_noise_px, rng)
        if self.axial_noise:
            depth = depth_errors.add_axial_noise(depth, self.axial_noise, rng) * (depth > 0)
        if self.disparity_step_per_m:
            depth = depth_errors.round_disparity(depth, self.disparity_step_per_m)
        if self.depth_step_m:
            depth = depth_errors.round_depth(depth, self.depth_step_m)
        if self.edge_dropout:
            chance = np.float32(self.edge_dropout) * depth_errors.depth_edges(true)
            depth = depth_errors.lose(depth, chance, rng)
        if self.grazing_dropout:
            chance = np.float32(self.grazing_dropout) * depth_errors.grazing(true, camera)
            depth = depth_errors.lose(depth, chance, rng)
        if self.range_m != (0.0, math.inf):
            depth = depth * ((depth >= self.range_m[0]) & (depth <= self.range_m[1]))
        return depth
