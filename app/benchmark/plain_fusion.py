"""Baseline of `razer bench`: Open3D's plain TSDF fusion of the same frames, with no labels at all."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from time import perf_counter

import numpy as np
import open3d as o3d
import open3d.core as o3c

from app.profiling.map_device import MapDevice
from razer.config import VoxelSettings
from razer.frame import Frame
from razer.geometry import inverse

_BLOCK_RESOLUTION = 16


def time_plain_fusion(
    frames: Iterable[Frame],
    settings: VoxelSettings,
    capacity: int,
    device: MapDevice,
    clock: Callable[[], float] = perf_counter,
) -> list[float]:
    """Milliseconds for each posed frame of compute_unique_block_coordinates + integrate on a device.

    Preparing the images is not counted, but bringing them there is. The grid has Open3D's own attributes only, and
    starts with room for `capacity` blocks. `clock` gives seconds.
    """
    grid = o3d.t.geometry.VoxelBlockGrid(
        ("tsdf", "weight", "color"),
        (o3c.float32, o3c.float32, o3c.float32),
        tuple(o3c.SizeVector([channels]) for channels in (1, 1, 3)),
        settings.voxel_size_m,
        _BLOCK_RESOLUTION,
        capacity,
        o3c.Device(device.name),
    )
    return [_fuse(grid, frame, settings, device, clock) for frame in frames]


def _fuse(
    grid: o3d.t.geometry.VoxelBlockGrid,
    frame: Frame,
    settings: VoxelSettings,
    device: MapDevice,
    clock: Callable[[], float],
) -> float:
    color_floats = frame.rgb.astype(np.float32) / 255  # integrate wants the type of the depth
    intrinsic = o3c.Tensor(frame.intrinsics.matrix)
    extrinsic = o3c.Tensor(inverse(frame.pose))
    limits = (1.0, settings.depth_max_m, settings.truncation_voxels)
    started_s = clock()
    depth, color = (
        o3d.t.geometry.Image(o3c.Tensor(np.ascontiguousarray(pixels)).to(o3c.Device(device.name)))
        for pixels in (frame.depth, color_floats)
    )
    blocks = grid.compute_unique_block_coordinates(depth, intrinsic, extrinsic, *limits)
    grid.integrate(blocks, depth, color, intrinsic, extrinsic, *limits)
    device.wait()
    return 1e3 * (clock() - started_s)
