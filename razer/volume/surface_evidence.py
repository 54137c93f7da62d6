"""Evidence for surface: how many observations a voxel needs, by how often frames saw its surroundings.

Where few frames saw a block, a single reading is all there is, and right in nearly all cases; where many did, what only
one of them showed is a reading gone astray beside an edge. So a share of the block's observations is asked, up to a
number that chance does not reach."""

from __future__ import annotations

from torch import Tensor

from razer.config import VoxelSettings


def is_observed_enough(weight: Tensor, settings: VoxelSettings) -> Tensor:
    """Which voxels of blocks (B, 4096) may hold surface, by their numbers of observations (B, 4096)."""
    of_block = weight.amax(dim=1, keepdim=True)
    return weight >= (settings.surface_share * of_block).clamp(1.0, settings.surface_weight)
