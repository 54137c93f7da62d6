"""TSDF integration of one frame's depth and colour, d <- (w d + w_obs d_obs) / (w + w_obs).

The division is what the paper's line lacks. Readings that the colour camera does not see are fused without colour:
Open3D then raises the voxel's one weight and leaves its colour as it is, which is right for a voxel that has a colour,
since it is as if the same had been seen again. One that has none yet would be taken for black from there on; so the
first colour that it gets is scaled to count in full.

Open3D's w_obs is 1. A frame that counts less is fused into weights that are scaled up by as much, and down again after:
(w / a) d + d_obs over w / a + 1 is w d + a d_obs over w + a.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import open3d as o3d
import open3d.core as o3c
import torch
from torch import Tensor

from razer.arrays import Float32Array, Float64Array, Int32Array, Uint8Array
from razer.config import VoxelSettings
from razer.detection.observed_surface import BLOCK_VOXELS, ObservedSurface
from razer.errors import UnusableFrame
from razer.frame import Frame
from razer.geometry import inverse
from razer.volume.blocks.block_pages import BlockPages, addresses_in

# Of the focal length, for colour; at the corner of an image of 4096 pixels it moves a projection by a fifth of one.
DRAWN_IN = 1e-4


class FrameFusion:
    """Fuses frames into pages of blocks; knows which of these may hold voxels without colour."""

    def __init__(self, pages: BlockPages, settings: VoxelSettings, device: o3c.Device) -> None:
        self._pages = pages
        self._settings = settings
        self._device = device
        self._maybe_colorless: set[bytes] = set()

    @property
    def colorless(self) -> Int32Array:
        """The blocks (B, 3) that may hold voxels without colour."""
        return np.frombuffer(b"".join(sorted(self._maybe_colorless)), np.int32).reshape(-1, 3)

    @colorless.setter
    def colorless(self, block_keys: Int32Array) -> None:
        self._maybe_colorless = {key.tobytes() for key in np.ascontiguousarray(block_keys, np.int32)}

    def fuse(self, frame: Frame, block_keys: Int32Array) -> None:
        """Fuse a posed frame into blocks (B, 3), which the pages have."""
        nearest = self._settings.depth_min_m
        depth = np.where(frame.depth >= nearest, frame.depth, np.float32(0)) if nearest else frame.depth
        if frame.has_color is None:
            self._integrate(frame, block_keys, depth, frame.rgb)
            return
        late = self._colorless(block_keys)
        (before,) = self._pages.read(late, "weight")
        self._integrate(frame, block_keys, np.where(frame.has_color, depth, np.float32(0)), frame.rgb)
        self._count_in_full(late, before)
        self._fuse_hidden(replace(frame, depth=np.where(frame.has_color, np.float32(0), depth)))

    def _fuse_hidden(self, frame: Frame) -> None:
        """Fuse the depth of readings that have no colour."""
        s = self._settings
        try:
            surface = ObservedSurface.of(frame, s.voxel_size_m, s.depth_min_m, s.depth_max_m)
        except UnusableFrame:  # no such reading
            return
        block_keys = surface.blocks_within(s.truncation_m)
        self._pages.add(block_keys)
        self._integrate(frame, block_keys, frame.depth, None)
        self._maybe_colorless.update(key.tobytes() for key in np.ascontiguousarray(block_keys, np.int32))

    def _integrate(self, frame: Frame, block_keys: Int32Array, depth: Float32Array, rgb: Uint8Array | None) -> None:
        intrinsic, extrinsic = o3c.Tensor(frame.intrinsics.matrix), o3c.Tensor(inverse(frame.pose))
        limits = 1.0, self._settings.depth_max_m, self._settings.truncation_voxels
        readings = self._image(depth)
        self._scale_weights(block_keys, 1 / frame.weight)
        if rgb is None:
            self._pages.integrate(block_keys, readings, intrinsic, extrinsic, *limits)
        else:
            color = self._image(np.multiply(rgb, np.float32(1 / 255), dtype=np.float32))
            inwards = o3c.Tensor(_drawn_in(frame.intrinsics.matrix))
            self._pages.integrate(block_keys, readings, color, intrinsic, inwards, extrinsic, *limits)
        self._scale_weights(block_keys, frame.weight)

    def _scale_weights(self, block_keys: Int32Array, times: float) -> None:
        """Let all that was observed in blocks (B, 3) so far count so many times. Powers of two are exact."""
        if times != 1:
            rows = self._pages.find(block_keys)
            addresses = addresses_in(rows, torch.ones((len(rows), BLOCK_VOXELS), dtype=torch.bool, device=rows.device))
            self._pages.write(addresses, weight=times * self._pages.read(addresses, "weight")[0])

    def _image(self, pixels: Float32Array) -> o3d.t.geometry.Image:
        return o3d.t.geometry.Image(o3c.Tensor(np.ascontiguousarray(pixels)).to(self._device))

    def _colorless(self, block_keys: Int32Array) -> Tensor:
        """Addresses of voxels of these blocks that were observed, and never with a colour."""
        keys = np.ascontiguousarray(block_keys, np.int32)
        known = [key for key in keys if key.tobytes() in self._maybe_colorless]
        rows = self._pages.find(np.array(known, np.int32).reshape(-1, 3))
        # One channel of whole blocks, and the others only where that one is 0.
        addresses = self._pages.select(
            rows, lambda weight, color: ((weight > 0) & (color == 0))[..., 0], "weight", "color", n_channels=1
        )
        return addresses[(self._pages.read(addresses, "color")[0] == 0).all(dim=1)]

    def _count_in_full(self, addresses: Tensor, weight_before: Tensor) -> None:
        """Scale the mean of no colour and the first one to the first one."""
        weight, color = self._pages.read(addresses, "weight", "color")
        gained = torch.nonzero((weight > weight_before)[:, 0]).squeeze(1)
        scale = weight[gained] / (weight - weight_before)[gained]
        self._pages.write(addresses[gained], color=color[gained] * scale)


def _drawn_in(matrix: Float64Array) -> Float64Array:
    """The camera matrix (3, 3) with which Open3D looks a pixel's colour up. It takes the pixel to a ray and back, which
    rounding can take just off the image: with one matrix for both, and most of all on CUDA, voxels behind the first row
    and column had weight and no colour, and grew dark. Pixels are looked up by rounding: this finds the same ones."""
    result = matrix.copy()
    result[[0, 1], [0, 1]] *= 1 - DRAWN_IN
    return result
