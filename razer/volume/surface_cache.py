"""Cache of the surface voxels of a volume, block by block: only blocks that were touched since the last look are read
again, and only those that hold something of a track for it.

Renewing the tracks' boxes and won shares would else take the longer the larger the map is.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from razer.arrays import Float64Array, Int32Array, Int64Array
from razer.detection.observed_surface import BLOCK_VOXELS
from razer.volume.blocks.block_pages import BLOCKS_AT_ONCE
from razer.volume.id_remap import numbered
from razer.volume.voxel_map import VoxelMap


@dataclass(frozen=True)
class SurfaceVoxels:
    """N voxels that hold surface: addresses (N,), and labels (N,), ids and counts (N, K) as they are stored, before the
    id remap."""

    addresses: Tensor
    labels: Tensor
    ids: Tensor
    counts: Tensor

    @classmethod
    def at(cls, volume: VoxelMap, addresses: Tensor) -> SurfaceVoxels:
        """The voxels at addresses (N,)."""
        label, ids, counts = volume.pages.read(addresses, "label", "ids", "counts")
        return cls(addresses, label[:, 0], ids, counts)


class SurfaceCache:
    """Where a volume has surface, and whose, as of the last call of `renew`."""

    def __init__(self) -> None:
        self._forget(None)

    def _forget(self, volume: VoxelMap | None) -> None:
        """Begin anew, with a volume of which nothing is known."""
        self._volume = volume
        self._addresses: dict[int, Tensor] = {}
        self._ids: dict[int, set[int]] = {}
        self._rows_of: dict[int, set[int]] = defaultdict(set)

    def renew(self, volume: VoxelMap) -> set[int] | None:
        """Look at what was touched; returns the instances whose voxels may have changed, None = any."""
        touched = volume.take_touched()
        if self._volume is not volume or touched is None:
            self._forget(volume)
            self._look(volume, volume.pages.all()[1])
            return None
        return set(volume.resolve(torch.tensor(sorted(self._look(volume, touched)), dtype=torch.int64)).tolist())

    def _look(self, volume: VoxelMap, rows: Tensor) -> set[int]:
        """Read the blocks of given rows (B,) again; returns all ids, before the id remap, that they had or have."""
        changed: set[int] = set()
        for part in rows.split(BLOCKS_AT_ONCE):
            voxels = SurfaceVoxels.at(volume, volume.surface_in(part))
            block = _places_in(part, voxels.addresses // BLOCK_VOXELS)
            per_block = voxels.addresses.split(torch.bincount(block, minlength=len(part)).tolist())
            ids_of = _ids_by_block(voxels, block, volume.newest_id)
            for number, (row, addresses) in enumerate(zip(part.tolist(), per_block, strict=True)):
                self._addresses[row] = addresses.clone()  # a view would keep all of the part in memory
                changed |= self._note_ids(row, ids_of[number])
        return changed

    def _note_ids(self, row: int, ids: set[int]) -> set[int]:
        before = self._ids.get(row, set())
        for gone in before - ids:
            self._rows_of[gone].discard(row)
        for new in ids - before:
            self._rows_of[new].add(row)
        self._ids[row] = ids
        return before | ids

    def around(self, instances: Collection[int]) -> SurfaceVoxels:
        """The surface voxels of all blocks in which one of some instances owns one, or has votes."""
        volume = self._known_volume
        known, wanted = sorted(self._rows_of), set(instances)
        now = volume.resolve(torch.tensor(known, dtype=torch.int64)).tolist()
        rows = set[int]().union(*(self._rows_of[i] for i, of in zip(known, now, strict=True) if of in wanted))
        nothing = torch.zeros(0, dtype=torch.int64, device=volume.torch_device)
        return SurfaceVoxels.at(volume, torch.cat([nothing, *(self._addresses[row] for row in sorted(rows))]))

    @property
    def _known_volume(self) -> VoxelMap:
        assert self._volume is not None, "renew comes first"
        return self._volume


def _places_in(rows: Tensor, of: Tensor) -> Tensor:
    """Where each of some rows (N,) stands in rows (B,) without repetition."""
    order = torch.argsort(rows)
    return order[torch.searchsorted(rows[order], of)]


def _ids_by_block(voxels: SurfaceVoxels, block: Tensor, newest_id: int) -> dict[int, set[int]]:
    """The ids that own voxels or have votes in each block, by the number (N,) of the block of each voxel."""
    labels = voxels.labels[:, None]
    known, number = numbered(torch.cat([labels, torch.where(voxels.counts > 0, voxels.ids, labels)], dim=1), newest_id)
    n_blocks = int(block.max()) + 1 if len(block) else 0
    occurs = torch.zeros((n_blocks, len(known)), dtype=torch.bool, device=block.device)
    occurs[block[:, None].expand_as(number), number] = True
    result: dict[int, set[int]] = defaultdict(set)
    values = known.tolist()
    for row, column in torch.nonzero(occurs).tolist():
        result[row].add(values[column])
    return result


def points_by_instance(volume: VoxelMap, surface: SurfaceVoxels, instances: Iterable[int]) -> dict[int, Float64Array]:
    """Positions (n, 3) of the surface voxels of each of some instances, in the order of the lattice: where a block lies
    in memory differs from run to run."""
    wanted = torch.zeros(volume.newest_id + 1, dtype=torch.bool, device=surface.labels.device)
    known = sorted(instances)
    wanted[known] = True
    owner = volume.resolve(surface.labels)
    own = torch.nonzero(wanted[owner.long()]).squeeze(1)
    owners = owner[own].cpu().numpy()
    positions = volume.pages.positions(surface.addresses[own]).cpu().numpy().astype(np.float64)
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
