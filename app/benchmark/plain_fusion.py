"""Baseline of `razer bench`: Open3D's plain TSDF fusion of the same frames, with no labels at all."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

import numpy as np
import open3d as o3d
import open3d.core as o3c

from app.profiling.map_device import MapDevice
from razer.config import VoxelSettings
from razer.frame import Frame
from razer.geometry import inverse

_BLOCK_RESOLUTION = 16


class PlainFusion:
    """A grid with Open3D's own attributes only, which starts with room for `capacity` blocks; `clock` gives seconds."""

    def __init__(
        self, settings: VoxelSettings, capacity: int, device: MapDevice, clock: Callable[[], float] = perf_counter
    ) -> None:
        self._settings, self._device, self._clock = settings, device, clock
        self._grid = o3d.t.geometry.VoxelBlockGrid(
            ("tsdf", "weight", "color"),
            (o3c.float32, o3c.float32, o3c.float32),
            tuple(o3c.SizeVector([channels]) for channels in (1, 1, 3)),
            settings.voxel_size_m,
            _BLOCK_RESOLUTION,
            capacity,
            o3c.Device(device.name),
        )

    def fuse_ms(self, frame: Frame) -> float:
        """Milliseconds that compute_unique_block_coordinates + integrate take for a posed frame. Preparing the images
        is not counted, but bringing them to the device is."""
        color_floats = frame.rgb.astype(np.float32) / 255  # integrate wants the type of the depth
        intrinsic = o3c.Tensor(frame.intrinsics.matrix)
        extrinsic = o3c.Tensor(inverse(frame.pose))
        limits = (1.0, self._settings.depth_max_m, self._settings.truncation_voxels)
        started_s = self._clock()
        depth, color = (
            o3d.t.geometry.Image(o3c.Tensor(np.ascontiguousarray(pixels)).to(o3c.Device(self._device.name)))
            for pixels in (frame.depth, color_floats)
        )
        blocks = self._grid.compute_unique_block_coordinates(depth, intrinsic, extrinsic, *limits)
        self._grid.integrate(blocks, depth, color, intrinsic, extrinsic, *limits)
        self._device.wait()
        return 1e3 * (self._clock() - started_s)
