"""How well the voxels bear a track out (section III-E).

The paper divides voxels by the volume of the box, which mixes units and tends to 0 for thin surfaces. Here the
support of a track is the share of its votes, on the surface, that lie in voxels it won. Votes and not voxels are
counted because one mask that joined a cup with its wall claims the wall's whole surface, but only once.
"""

from __future__ import annotations

import torch

from razer.voxels import VoxelMap


def support_ratios(voxels: VoxelMap) -> dict[int, float]:
    """r_i in [0, 1] for each instance with any votes."""
    surface = voxels.surface_addresses()
    n_ids = voxels.newest_id + 1
    ids = voxels.alive(voxels.attribute("ids")[surface])
    votes = voxels.attribute("counts")[surface].double()
    label = voxels.alive(voxels.attribute("label")[surface])

    def votes_of(which: torch.Tensor) -> torch.Tensor:
        return torch.bincount(ids[which].long(), weights=votes[which], minlength=n_ids)

    given, kept = votes_of(votes > 0), votes_of((votes > 0) & (ids == label))
    ratio = kept / given.clamp(min=1)
    return {i: r for i, r in enumerate(ratio.tolist()) if i and given[i] > 0}
