"""Support ratio of instances: how far the voxels bear a track out (RAZER eq. 15).

The paper divides voxels by the volume of the box, which mixes units and tends to 0 for thin surfaces. Here the
support of a track is the share of its votes, on the surface, that lie in voxels it won. Votes and not voxels are
counted because one mask that joined a cup with its wall claims the wall's whole surface, but only once.
"""

from __future__ import annotations

import torch

from razer.volume.surface_cache import SurfaceVoxels
from razer.volume.voxel_map import VoxelMap


def support_ratios(voxels: VoxelMap, surface: SurfaceVoxels) -> dict[int, float]:
    """r_i in [0, 1] for each instance with any votes on the surface of a volume."""
    ids = voxels.resolve(surface.ids)
    votes = surface.counts
    has_votes = votes > 0
    won = (ids == voxels.resolve(surface.labels)[:, None])[has_votes]
    voter, weight = ids[has_votes].long(), votes[has_votes].double()
    n_ids = voxels.newest_id + 1
    total = torch.bincount(voter, weights=weight, minlength=n_ids)
    kept = torch.bincount(voter[won], weights=weight[won], minlength=n_ids)
    ratio = kept / total.clamp(min=1)
    return {i: r for i, r in enumerate(ratio.tolist()) if i and total[i] > 0}
