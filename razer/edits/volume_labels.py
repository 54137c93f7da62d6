"""Labels of the volume after edits: each voxel's votes go where the surface next to it went."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import torch
from scipy.spatial import KDTree
from torch import Tensor

from razer.arrays import Float32Array, Int32Array
from razer.detection.observed_surface import BLOCK
from razer.mesh.labelled_mesh import LabelledMesh
from razer.volume.voxel_map import VoxelMap


def relabelled(voxels: VoxelMap, before: LabelledMesh, after: Int32Array, gone: Iterable[int] = ()) -> VoxelMap:
    """A volume, changed in place, whose votes for an instance are for what the nearest of its vertices is now.

    Args:
        voxels: the volume that a mesh was taken from.
        before: the mesh, with the labels that the volume gave it.
        after: its labels (V,) after the edits.
        gone: ids that are no more.
    """
    voxels.settle()
    voxels.admit(max(voxels.newest_id, int(after.max(initial=0))))
    changed = before.instances != after
    moves = []
    for instance in np.unique(before.instances[changed]).tolist():
        rows = before.instances == instance
        if instance and instance <= voxels.newest_id:
            moves.append((instance, *_moves(voxels, instance, before.vertices[rows], after[rows])))
    # Marked by their sign, so that what came to an instance does not leave it again with its own votes.
    for instance, addresses, targets in moves:
        _mark(voxels, instance, addresses, targets)
    for _, addresses, _ in moves:
        voxels.pages.write(addresses, ids=voxels.pages.read(addresses, "ids")[0].abs())
        voxels.relabel(addresses)
    for instance in gone:  # votes far from its surface
        voxels.replace(instance, 0)
    voxels.settle()
    return voxels


def _moves(voxels: VoxelMap, instance: int, vertices: Float32Array, targets: Int32Array) -> tuple[Tensor, Tensor]:
    """Addresses (N,) of the voxels around the vertices (n, 3) of an instance that have votes for it, and what (N,)
    those votes are for once the vertices are of `targets` (n,)."""
    size_m = BLOCK * voxels.settings.voxel_size_m
    low, high = (np.floor(end / size_m).astype(np.int32) for end in (vertices.min(axis=0), vertices.max(axis=0)))

    def has_votes(ids: Tensor, counts: Tensor) -> Tensor:
        return ((ids == instance) & (counts > 0)).any(dim=2)

    rows = voxels.pages.within(low - 1, high + 1)[1]
    addresses = voxels.pages.select(rows, has_votes, "ids", "counts")
    _, nearest = KDTree(vertices).query(voxels.pages.positions(addresses).cpu().numpy())
    return addresses, torch.from_numpy(targets[nearest].astype(np.int32)).to(voxels.torch_device)


def _mark(voxels: VoxelMap, instance: int, addresses: Tensor, targets: Tensor) -> None:
    """Give votes for an instance to minus their targets (N,); what it owned and nobody has now loses all votes."""
    ids, counts, labels = voxels.pages.read(addresses, "ids", "counts", "label")
    is_nobodys = ((labels[:, 0] == instance) & (targets == 0))[:, None]
    own = ids == instance
    ids = torch.where(own, -targets[:, None], ids)
    counts = torch.where(is_nobodys | (own & (targets == 0)[:, None]), 0, counts)
    voxels.pages.write(addresses, ids=torch.where(counts > 0, ids, 0), counts=counts)
