"""Adoption of a rebuilt map: instance ids carried over, duplicates fused, boxes renewed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch

from razer.arrays import Int32Array
from razer.reintegration.id_matching import majority_ids, match_ids
from razer.tracking.duplicates import find_duplicates
from razer.tracking.panoptic_integrator import PanopticIntegrator
from razer.volume.voxel_map import VoxelMap

_NOBODY = np.zeros(0, np.int32)


def adopt_volume(
    integrator: PanopticIntegrator, rebuilt: VoxelMap, owners: Sequence[Int32Array]
) -> list[tuple[int, int]]:
    """Go on with a rebuilt volume, `owners` being the tracks (N,) of each kept frame's detections: duplicates that it
    brings to light are fused, boxes are renewed. Returns pairs (gone, survivor)."""
    integrator.voxels = rebuilt
    fused = []
    min_shared = integrator.config.reintegration.fuse_shared_votes
    while duplicates := integrator.tracker.fuse_alike(find_duplicates(rebuilt, owners, min_shared)):
        for pair in duplicates:
            integrator.replace(*pair)
        fused += duplicates
    integrator.refresh_tracks()
    return fused


def adopt_tracks(
    integrator: PanopticIntegrator,
    successor: PanopticIntegrator,
    owners_before: Sequence[Int32Array],
    owners_after: Sequence[Int32Array],
) -> None:
    """Go on with the tracks of a second pass, which take the ids of those they were in the first.

    Args:
        integrator: Holds the tracks of the first pass; those of the second take their place.
        successor: Holds the tracks of the second pass, whose ids are others.
        owners_before: The track of each detection in the first pass, an array (N,) for each frame.
        owners_after: The same in the second pass.
    """
    voxels = integrator.voxels  # both volumes read ids through one table
    before, after = (_resolved(voxels, np.concatenate([_NOBODY, *ids])) for ids in (owners_before, owners_after))
    matched_ids = match_ids(before, after)
    successor.tracker.rename(matched_ids)
    for new_id, old_id in matched_ids.items():
        successor.replace(new_id, old_id)
    # An id without a match is read as the one that most of it went to, if any.
    majority = majority_ids(before, _resolved(voxels, after))
    for gone in set(integrator.tracker.tracks) - set(matched_ids.values()):
        voxels.replace(gone, majority.get(gone, 0))
    integrator.tracker, integrator.parts = successor.tracker, successor.parts


def _resolved(voxels: VoxelMap, ids: Int32Array) -> Int32Array:
    return voxels.resolve(torch.from_numpy(ids)).cpu().numpy()
