"""Bounded label histogram h of a voxel: K slots of (instance id, count), kept by the Misra-Gries rule (1982).

A known id gains one; a new id takes an empty slot; when all slots are taken every one loses one instead, so
that a late but right label wins in the end. Histograms are (K, n), a row for each slot: arithmetic along rows is
several times faster than across a last dimension of four. Pure tensor arithmetic, on any device.
"""

from __future__ import annotations

import torch
from torch import Tensor

MAX_COUNT = 30_000  # int16 without overflow


def cast(ids: Tensor, counts: Tensor, votes: Tensor) -> tuple[Tensor, Tensor]:
    """Histograms (K, n) int32 ids and int16 counts after one vote (n,) each; a vote for 0 is no vote."""
    match = (ids == votes) & (counts > 0)
    known = match.any(dim=0)
    empty = counts == 0
    seeks = ~known & (votes > 0)
    gains = []
    for slot in range(len(ids)):
        takes = seeks & empty[slot]
        seeks = seeks & ~takes
        gains.append(match[slot] | takes)
    gain = torch.stack(gains)
    # Whoever still seeks a slot has found all of them taken.
    counts = (counts + gain.to(counts.dtype) - seeks.to(counts.dtype)).clamp_(0, MAX_COUNT)
    return torch.where(counts > 0, torch.where(gain, votes, ids), 0), counts


def withdraw(ids: Tensor, counts: Tensor, lost: Tensor) -> tuple[Tensor, Tensor]:
    """Histograms (K, n) after slots that are `lost` (K, n) gave up one vote."""
    counts = (counts - lost.to(counts.dtype)).clamp_(min=0)
    return torch.where(counts > 0, ids, 0), counts


def merge_equal(ids: Tensor, counts: Tensor) -> tuple[Tensor, Tensor]:
    """Add up slots that name the same instance, as after two instances were fused; id 0 is emptied."""
    counts = torch.where(ids > 0, counts, 0)
    for keep in range(len(ids)):
        for later in range(keep + 1, len(ids)):
            same = ids[keep] == ids[later]
            room = (MAX_COUNT - counts[keep]).clamp_(min=0)
            counts[keep] += torch.where(same, torch.minimum(counts[later], room), 0)
            counts[later] = torch.where(same, 0, counts[later])
    return torch.where(counts > 0, ids, 0), counts


def winner(ids: Tensor, counts: Tensor) -> Tensor:
    """The label l = arg max h (n,) int32, 0 where nobody has votes. Of equal counts the lowest id: the older track, and
    of those that one frame began that of the larger mask (`razer.detection.perception.in_order_of_content`)."""
    best_id, best_count = ids[0], counts[0]
    for slot in range(1, len(ids)):
        better = (counts[slot] > best_count) | ((counts[slot] == best_count) & (ids[slot] < best_id))
        best_id = torch.where(better, ids[slot], best_id)
        best_count = torch.where(better, counts[slot], best_count)
    return torch.where(best_count > 0, best_id, 0)
