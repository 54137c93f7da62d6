"""The bounded histogram h of a voxel: K slots of (instance id, count), kept by the Misra-Gries rule (1982).

A known id gains one; a new id takes an empty slot; when all slots are taken every one loses one instead, so
that a late but right label wins in the end. All functions are pure tensor arithmetic, on any device.
"""

from __future__ import annotations

import torch
from torch import Tensor

MAX_COUNT = 30_000  # int16 without overflow


def cast(ids: Tensor, counts: Tensor, votes: Tensor) -> tuple[Tensor, Tensor]:
    """Histograms (n, K) int32 ids and int16 counts after one vote (n,) each; a vote for 0 is no vote."""
    match = (ids == votes[:, None]) & (counts > 0)
    known = match.any(dim=1)
    empty = counts == 0
    takes = ~known & empty.any(dim=1)
    slot = torch.where(known, match.int().argmax(dim=1), empty.int().argmax(dim=1))
    voted = votes > 0
    gains = torch.zeros_like(match).scatter_(1, slot[:, None], ((known | takes) & voted)[:, None])
    full = ~known & ~takes & voted
    new_ids = torch.where(gains, votes[:, None], ids)
    new_counts = (counts + gains.to(counts.dtype) - full[:, None].to(counts.dtype)).clamp_(0, MAX_COUNT)
    return torch.where(new_counts > 0, new_ids, 0), new_counts


def merge_equal(ids: Tensor, counts: Tensor) -> tuple[Tensor, Tensor]:
    """Add up slots that name the same instance, as after two instances were fused; id 0 is emptied."""
    counts = torch.where(ids > 0, counts, 0)
    slots = ids.shape[1]
    for keep in range(slots):
        for other in range(keep + 1, slots):
            same = (ids[:, keep] == ids[:, other]) & (ids[:, keep] > 0)
            moved = torch.where(same, counts[:, other], 0)
            counts[:, keep] += moved
            counts[:, other] -= moved
    return torch.where(counts > 0, ids, 0), counts


def winner(ids: Tensor, counts: Tensor) -> Tensor:
    """The label l = arg max h (n,) int32: of equal counts the lowest id; 0 where nobody has votes."""
    most = counts.max(dim=1, keepdim=True).values
    best = (counts == most) & (counts > 0)
    lowest = torch.where(best, ids, torch.iinfo(ids.dtype).max).min(dim=1).values
    return torch.where(best.any(dim=1), lowest, 0)
