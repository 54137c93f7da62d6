"""How well the voxels bear a track out (section III-E).

The paper divides voxels by the volume of the box, which mixes units and tends to 0 for thin surfaces. Here the
expected surface of a track is every voxel that holds votes for it, and its support the share of those it won.
"""

from __future__ import annotations

import torch

from razer.voxels import BLOCKS_AT_ONCE, VoxelMap


def support_ratios(voxels: VoxelMap) -> dict[int, float]:
    """r_i in [0, 1] for each instance with any votes."""
    slot_ids, slot_counts, label = (voxels.attribute(name) for name in ("ids", "counts", "label"))
    n_ids = voxels.newest_id + 1
    claimed = torch.zeros(n_ids, dtype=torch.int64, device=voxels.torch_device)
    owned = torch.zeros_like(claimed)
    for rows in voxels.active_rows()[1].split(BLOCKS_AT_ONCE):
        voted = voxels.select(rows, lambda label: label[..., 0] > 0, "label")
        counts = slot_counts[voted]
        claimed += torch.bincount(voxels.alive(slot_ids[voted])[counts > 0].long(), minlength=n_ids)
        owned += torch.bincount(voxels.alive(label[voted, 0]).long(), minlength=n_ids)
    ratio = owned / claimed.clamp(min=1)
    return {i: r for i, r in enumerate(ratio.tolist()) if i and claimed[i] > 0}
