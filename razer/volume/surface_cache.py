"""Cache of the surface voxels of a volume: only blocks that were touched since the last extraction are read again.

Renewing the tracks' boxes and support would else take the longer the larger the map is.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields

import numpy as np
import torch
from torch import Tensor

from razer.arrays import Float64Array, Int32Array, Int64Array
from razer.detection.observed_surface import BLOCK_VOXELS
from razer.volume.voxel_map import VoxelMap


@dataclass(frozen=True)
class SurfaceVoxels:
    """N voxels that hold surface: addresses (N,), positions (N, 3) float32 metres, and labels (N,), ids and counts
    (N, K) as they are stored, before the id remap."""

    addresses: Tensor
    positions: Tensor
    labels: Tensor
    ids: Tensor
    counts: Tensor

    @classmethod
    def at(cls, volume: VoxelMap, addresses: Tensor) -> SurfaceVoxels:
        """The voxels at addresses (N,)."""
        label, ids, counts = (volume.attribute(name)[addresses] for name in ("label", "ids", "counts"))
        return cls(addresses, volume.positions(addresses), label[:, 0], ids, counts)

    def select(self, keep: Tensor) -> SurfaceVoxels:
        """Those where `keep` (N,) holds."""
        return SurfaceVoxels(*(getattr(self, part.name)[keep] for part in fields(self)))

    def joined(self, other: SurfaceVoxels) -> SurfaceVoxels:
        """These and others."""
        return SurfaceVoxels(*(torch.cat([getattr(of, part.name) for of in (self, other)]) for part in fields(self)))

    def instances(self, volume: VoxelMap) -> set[int]:
        """The instances that own one of them, or have votes there."""
        votes = self.ids[self.counts > 0]
        return set(volume.resolve(torch.unique(torch.cat([self.labels, votes]))).tolist())


class SurfaceCache:
    """All surface voxels of a volume, as of the last call of `renew`."""

    def __init__(self) -> None:
        self._volume: VoxelMap | None = None
        self._voxels: SurfaceVoxels | None = None

    def renew(self, volume: VoxelMap) -> tuple[SurfaceVoxels, set[int] | None]:
        """The surface voxels as they are now, and the instances whose voxels may have changed; None = any."""
        touched = volume.take_touched()
        if self._voxels is None or self._volume is not volume or touched is None:
            self._volume, self._voxels = volume, SurfaceVoxels.at(volume, volume.surface_addresses())
            return self._voxels, None
        is_touched = torch.zeros(int(volume.grid.hashmap().capacity()), dtype=torch.bool, device=touched.device)
        is_touched[touched] = True
        stale = is_touched[self._voxels.addresses // BLOCK_VOXELS]
        fresh = SurfaceVoxels.at(volume, volume.surface_in(touched))
        changed = self._voxels.select(stale).instances(volume) | fresh.instances(volume)
        self._voxels = self._voxels.select(~stale).joined(fresh)
        return self._voxels, changed


def points_by_instance(volume: VoxelMap, surface: SurfaceVoxels, instances: Iterable[int]) -> dict[int, Float64Array]:
    """Positions (n, 3) of the surface voxels of each of some instances, in the order of the lattice: where a block lies
    in memory differs from run to run."""
    wanted = torch.zeros(volume.newest_id + 1, dtype=torch.bool, device=surface.labels.device)
    known = sorted(instances)
    wanted[known] = True
    owner = volume.resolve(surface.labels)
    own = wanted[owner.long()]
    owners, positions = owner[own].cpu().numpy(), surface.positions[own].cpu().numpy().astype(np.float64)
    order = np.argsort(_rank(owners, positions, volume.settings.voxel_size_m))
    bounds = np.searchsorted(owners[order], [known, [i + 1 for i in known]]).T
    return {i: positions[order[start:end]] for i, (start, end) in zip(known, bounds, strict=True)}


def _rank(owners: Int32Array, positions: Float64Array, size_m: float) -> Int64Array:
    """Numbers (N,), no two alike, in the order of the owners and then of the places on the lattice."""
    place = np.rint(positions / size_m).astype(np.int64)
    x, y, z = (place - place.min(axis=0, initial=0)).T
    _, n_y, n_z = shape = (place.max(axis=0, initial=0) - place.min(axis=0, initial=0) + 1).tolist()
    rank: Int64Array = owners * np.int64(np.prod(shape)) + (x * n_y + y) * n_z + z
    return rank
