"""How well the voxels bear a track out (section III-E).

The paper divides voxels by the volume of the box, which mixes units and tends to 0 for thin surfaces. Here the
expected surface of a track is every surface voxel that holds votes for it, and its support the share of those it won.
"""

from __future__ import annotations

import torch

from razer.voxels import VoxelMap


def support_ratios(voxels: VoxelMap) -> dict[int, float]:
    """r_i in [0, 1] for each instance with any votes."""
    slot_ids, slot_counts, label = (voxels.attribute(name) for name in ("ids", "counts", "label"))
    n_ids = voxels.newest_id + 1
    surface = voxels.surface_addresses()
    claimed = torch.bincount(voxels.alive(slot_ids[surface])[slot_counts[surface] > 0].long(), minlength=n_ids)
    owned = torch.bincount(voxels.alive(label[surface, 0]).long(), minlength=n_ids)
    ratio = owned / claimed.clamp(min=1)
    return {i: r for i, r in enumerate(ratio.tolist()) if i and claimed[i] > 0}
