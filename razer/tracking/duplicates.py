"""Duplicate detection after reintegration: once the poses have been corrected, two tracks of one thing claim the same
voxels, and no frame shows both."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
import torch

from razer.arrays import Int32Array
from razer.volume.label_histogram import merge_equal
from razer.volume.voxel_map import VoxelMap

Pair = tuple[int, int]
# One thing is one mask in most frames; two things beside each other are both visible in nearly all of them.
MAX_COVISIBILITY = 0.2


def find_duplicates(voxels: VoxelMap, owners: Sequence[Int32Array], min_shared: float) -> list[Pair]:
    """Pairs (older id, newer id) that share at least `min_shared` of their votes and are hardly ever covisible,
    the largest share first; `owners` are the tracks (N,) of each frame's detections."""
    shared = {pair: share for pair, share in shared_votes(voxels).items() if share >= min_shared}
    pairs = sorted(shared, key=lambda pair: (-shared[pair], pair))
    covisible = covisibility(pairs, owners, voxels)
    return [pair for pair, share in zip(pairs, covisible, strict=True) if share <= MAX_COVISIBILITY]


def covisibility(pairs: list[Pair], owners: Sequence[Int32Array], voxels: VoxelMap) -> list[float]:
    """For each pair of live instances the share of frames with both, among those of the one in fewer."""
    frame = np.repeat(np.arange(len(owners)), [len(ids) for ids in owners])
    instance = np.array(voxels.resolve(torch.from_numpy(np.concatenate([np.zeros(0, np.int32), *owners]))).tolist())
    frames_of = {i: set(frame[instance == i].tolist()) for pair in pairs for i in pair}
    return [len(frames_of[a] & frames_of[b]) / max(1, min(len(frames_of[a]), len(frames_of[b]))) for a, b in pairs]


def shared_votes(voxels: VoxelMap) -> dict[Pair, float]:
    """For pairs of instances (older id, newer id) the share of their votes on the surface that lies in the same
    voxels: the sum of min(h_a, h_b) over that of the one with fewer votes. Pairs that share none are left out.

    Votes and not voxels are compared, because a mask that joined a cup with its table claims every voxel of the cup,
    but only once.
    """
    surface = voxels.surface_addresses()
    ids, counts = (column.T.contiguous() for column in voxels.pages.read(surface, "ids", "counts"))
    ids, counts = merge_equal(voxels.resolve(ids), counts)
    n_ids = voxels.newest_id + 1
    total = torch.bincount(ids.flatten().long(), weights=counts.flatten().double(), minlength=n_ids).tolist()
    shared: dict[Pair, float] = {}
    for a, b in combinations(range(len(ids)), 2):
        both = torch.minimum(counts[a], counts[b])
        claimed = both > 0
        low, high = torch.minimum(ids[a], ids[b])[claimed].long(), torch.maximum(ids[a], ids[b])[claimed].long()
        pairs, row = torch.unique(low * n_ids + high, return_inverse=True)
        sums = torch.bincount(row, weights=both[claimed].double(), minlength=len(pairs))
        for key, n in zip(pairs.tolist(), sums.tolist(), strict=True):
            pair = divmod(key, n_ids)
            shared[pair] = shared.get(pair, 0.0) + n
    return {pair: n / min(total[pair[0]], total[pair[1]]) for pair, n in shared.items()}
