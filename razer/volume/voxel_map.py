"""TSDF volume with label histograms, V(p) = {d, w, c, l, h} (RAZER eq. 1), over Open3D's VoxelBlockGrid, on the CPU or
a CUDA device.

Attribute tensors are shared with torch by DLPack. Such a view goes silently stale when the grid grows, so each
method fetches its views afresh and none is kept. Everything host-side that is not a whole attribute (cell
addresses, per-instance counts) travels freely; attributes themselves leave the device in
`razer.volume.mesh_extraction` and `razer.storage` only.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import open3d as o3d
import open3d.core as o3c
import torch
from numpy.typing import NDArray
from torch import Tensor

from razer.arrays import BoolArray, Int32Array
from razer.config import VoxelSettings
from razer.detection.observed_surface import BLOCK, BLOCK_VOXELS, Cells, ObservedSurface
from razer.frame import Frame
from razer.volume import label_histogram
from razer.volume.frame_fusion import FrameFusion
from razer.volume.id_remap import InstanceIdMap

START_BLOCKS = 1024
GROWTH = 1.6
SPARE = 1.1  # room of a successor, since corrected poses fill somewhat other blocks
BLOCKS_AT_ONCE = 512  # of passes over the whole map, to bound their memory
SURFACE_VOXELS = 0.75  # a voxel this near to the zero crossing holds surface
FULL = 0.85  # share of the capacity beyond which the hash map is made larger beforehand


class VoxelMap:
    """Truncated signed distances with colours, and for each voxel its instance and a histogram of labels."""

    def __init__(
        self, settings: VoxelSettings, device: str = "CPU:0", id_map: InstanceIdMap | None = None, n_blocks: int = 0
    ) -> None:
        """An empty volume.

        Args:
            settings: Voxel size, truncation distance, depth range and histogram slots.
            device: As Open3D names it, "CPU:0" or "CUDA:0".
            id_map: Shared with another volume of the same instances; by default a new one.
            n_blocks: Blocks of 16^3 voxels to make room for, since growing takes seconds.
        """
        self.settings = settings
        self.device = o3c.Device(device)
        self.torch_device = torch.device("cuda" if device.upper().startswith("CUDA") else "cpu")
        slots = settings.histogram_slots
        self.grid = o3d.t.geometry.VoxelBlockGrid(
            ("tsdf", "weight", "color", "label", "ids", "counts"),
            (o3c.float32, o3c.float32, o3c.float32, o3c.int32, o3c.int32, o3c.int16),
            [o3c.SizeVector([n]) for n in (1, 1, 3, 1, slots, slots)],
            settings.voxel_size_m,
            BLOCK,
            max(START_BLOCKS, n_blocks),
            self.device,
        )
        self._fusion = FrameFusion(self.grid, settings, self.device, self.attribute, self.rows_of)
        # Fused instances: voxels keep the old id until next touched, and are read through this table.
        self._id_map = id_map or InstanceIdMap(self.torch_device)
        self._touched: Tensor | None = None  # which buffer rows, None = any

    def empty_copy(self) -> VoxelMap:
        """An empty volume of the same kind, for the same instances: fusions and prunings of one hold in both. It has
        room for as many blocks, since growing takes seconds."""
        return VoxelMap(self.settings, str(self.device), self._id_map, int(SPARE * self.n_blocks / FULL))

    @property
    def n_blocks(self) -> int:
        """Blocks of 16^3 voxels in use."""
        return int(self.grid.hashmap().size())

    @property
    def newest_id(self) -> int:
        """The largest id admitted so far."""
        return self._id_map.newest_id

    @property
    def memory_bytes(self) -> int:
        """Bytes the attributes of the grid's whole capacity take."""
        per_voxel = 4 + 4 + 12 + 4 + 6 * self.settings.histogram_slots
        return int(self.grid.hashmap().capacity()) * BLOCK_VOXELS * per_voxel

    def attribute(self, name: str) -> Tensor:
        """A fresh view (capacity * 4096, channels) of an attribute; valid until blocks are next allocated."""
        shared = self.grid.attribute(name)
        tensor = torch.utils.dlpack.from_dlpack(shared.to_dlpack())
        return tensor.reshape(shared.shape[0] * BLOCK_VOXELS, -1)

    def positions(self, addresses: Tensor) -> Tensor:
        """World positions (n, 3) float32 metres of voxels given by their addresses in the flat attributes."""
        keys = torch.utils.dlpack.from_dlpack(self.grid.hashmap().key_tensor().to_dlpack())
        place = addresses % BLOCK_VOXELS
        inside = torch.stack([place % BLOCK, place // BLOCK % BLOCK, place // BLOCK**2], dim=1)
        lattice = keys[addresses // BLOCK_VOXELS] * BLOCK + inside
        return lattice.float() * self.settings.voxel_size_m

    def integrate(self, frame: Frame, surface: ObservedSurface | None = None) -> Int32Array:
        """Fuse a posed frame, of which the observed `surface` may be known already; returns the sorted keys
        (M, 3) of the blocks within the truncation distance of it. Raises UnusableFrame without depth in range.
        """
        s = self.settings
        if surface is None:
            surface = ObservedSurface.of(frame, s.voxel_size_m, s.depth_min_m, s.depth_max_m)
        block_keys = surface.blocks_within(s.truncation_m)
        self._make_room(block_keys)
        self._fusion.fuse(frame, block_keys)
        self._touch(self.rows_of(block_keys))
        return block_keys

    def _touch(self, rows: Tensor) -> None:
        if self._touched is not None and len(self._touched) != self.grid.hashmap().capacity():
            self._touched = None  # it has grown, and rows were dealt out anew
        if self._touched is not None:
            self._touched[rows] = True

    def allocate(self, block_keys: Int32Array) -> None:
        """Add blocks (B, 3) of empty voxels."""
        if len(block_keys) == 0:
            return
        self._make_room(block_keys)
        self.grid.hashmap().activate(o3c.Tensor(np.ascontiguousarray(block_keys, dtype=np.int32)).to(self.device))

    def _make_room(self, block_keys: Int32Array) -> None:
        hashmap = self.grid.hashmap()
        room = int(FULL * hashmap.capacity()) - hashmap.size()
        if len(block_keys) > room and (n_more := int((self._rows(block_keys) < 0).sum())) > room:
            hashmap.reserve(int(GROWTH * (hashmap.size() + n_more)) + START_BLOCKS // 2)

    def _rows(self, block_keys: Int32Array) -> Tensor:
        """Buffer row of each block (B,) int64, -1 where the map has none."""
        if len(block_keys) == 0:
            return torch.zeros(0, dtype=torch.int64, device=self.torch_device)
        keys = o3c.Tensor(np.ascontiguousarray(block_keys, dtype=np.int32)).to(self.device)
        rows, exists = self.grid.hashmap().find(keys)
        rows, exists = (torch.utils.dlpack.from_dlpack(t.to(o3c.int64).to_dlpack()) for t in (rows, exists))
        return torch.where(exists > 0, rows, -1)

    def _addresses(self, cells: Cells) -> tuple[Tensor, Tensor]:
        """Rows of the flat attributes for the cells the map has, and the indices of those cells."""
        row = self._rows(cells.block_keys)[self._tensor(cells.block)]
        known = torch.nonzero(row >= 0).squeeze(1)
        return row[known] * BLOCK_VOXELS + self._tensor(cells.local)[known], known

    def _tensor(self, values: NDArray) -> Tensor:
        return torch.from_numpy(np.ascontiguousarray(values)).to(self.torch_device, torch.int64)

    def rows_of(self, block_keys: Int32Array) -> Tensor:
        """Buffer rows of those of the given blocks (B, 3) that the map has."""
        rows = self._rows(block_keys)
        return rows[rows >= 0]

    def histograms_at(self, cells: Cells) -> tuple[Tensor, Tensor]:
        """Ids and counts (C, K) of each cell's histogram, empty where the map has no such cell."""
        addresses, known = self._addresses(cells)
        shape = (len(cells), self.settings.histogram_slots)
        ids, counts = (torch.zeros(shape, dtype=torch.int64, device=self.torch_device) for _ in range(2))
        ids[known] = self.resolve(self.attribute("ids")[addresses]).long()
        counts[known] = self.attribute("counts")[addresses].long()
        return ids, counts

    def resolve(self, ids: Tensor) -> Tensor:
        """Ids after all fusions and prunings so far."""
        return self._id_map.resolve(ids)

    def labels_at(self, cells: Cells) -> Tensor:
        """The label (C,) int32 of each cell, 0 = nobody; stays on the device."""
        addresses, known = self._addresses(cells)
        result = torch.zeros(len(cells), dtype=torch.int32, device=self.torch_device)
        result[known] = self.resolve(self.attribute("label")[addresses, 0])
        return result

    def count_labels(self, labels: Tensor, group: Int32Array, cell: Int32Array) -> dict[tuple[int, int], int]:
        """How many cells of each group bear each label: {(group, id): cells}, nobody left out.

        group (M,) and cell (M,) list the members of all groups; `labels` is from `labels_at`.
        """
        n_ids = self.newest_id + 1
        counts = torch.bincount(self._tensor(group) * n_ids + labels[self._tensor(cell)])
        bins = torch.nonzero(counts).squeeze(1)
        table = zip(bins.tolist(), counts[bins].tolist(), strict=True)
        return {divmod(row, n_ids): n for row, n in table if row % n_ids}

    def admit(self, track_id: int) -> None:
        """Make a new id known; ids must be admitted in increasing order before they get votes."""
        self._id_map.admit(track_id)

    def replace(self, gone: int, survivor: int) -> None:
        """All that was `gone` is `survivor` from now on; survivor 0 forgets it. Voxels follow lazily."""
        self._id_map.replace(gone, survivor)

    def vote(
        self, cells: Cells, ids: Int32Array, visible_ids: Int32Array | None = None, withdraws: BoolArray | None = None
    ) -> None:
        """One vote for each cell that the map has; votes for an instance that was fused go to the survivor.

        Args:
            cells: C cells of the lattice.
            ids: The instance (C,) that each votes for; 0 = none.
            visible_ids: Live instances (T,) in the frame.
            withdraws: Which cells (C,) lose a vote of each other instance of `visible_ids`.
        """
        addresses, known = self._addresses(cells)
        cast = self.resolve(self._tensor(ids)[known])
        if visible_ids is None or withdraws is None:
            self._rewrite(addresses, lambda ids, counts: label_histogram.cast(ids, counts, cast))
            return
        is_visible = torch.zeros(self.newest_id + 1, dtype=torch.bool, device=self.torch_device)
        is_visible[self._tensor(visible_ids)] = True
        may_lose = torch.from_numpy(withdraws).to(self.torch_device)[known]

        def change(ids: Tensor, counts: Tensor) -> tuple[Tensor, Tensor]:
            lost = is_visible[ids.long()] & (ids != cast) & may_lose
            return label_histogram.cast(*label_histogram.withdraw(ids, counts, lost), cast)

        self._rewrite(addresses, change)

    def relabel(self, addresses: Tensor) -> None:
        """Renew the labels of voxels whose votes were changed from outside."""
        self._rewrite(addresses, label_histogram.merge_equal)

    def _rewrite(self, addresses: Tensor, change: Callable[[Tensor, Tensor], tuple[Tensor, Tensor]]) -> None:
        """Replace histograms (K, n) by what `change` makes of them, and renew the labels."""
        slot_ids, slot_counts = self.attribute("ids"), self.attribute("counts")
        stored_ids, counts = slot_ids[addresses].T.contiguous(), slot_counts[addresses].T.contiguous()
        ids = self.resolve(stored_ids)
        stale = torch.nonzero((ids != stored_ids).any(dim=0)).squeeze(1)
        ids[:, stale], counts[:, stale] = label_histogram.merge_equal(ids[:, stale], counts[:, stale])
        ids, counts = change(ids, counts)
        self._touch(addresses // BLOCK_VOXELS)
        slot_ids[addresses], slot_counts[addresses] = ids.T.contiguous(), counts.T.contiguous()
        self.attribute("label")[addresses, 0] = label_histogram.winner(ids, counts)

    def amplify(self, times: float) -> None:
        """Let every observation and vote so far count `times` times."""
        self._touched = None
        weight, counts = self.attribute("weight"), self.attribute("counts")
        weight.mul_(times)
        for part in counts.split(BLOCKS_AT_ONCE * BLOCK_VOXELS):
            part.copy_((part * times).round_().clamp_(max=label_histogram.MAX_COUNT))

    def active_rows(self) -> tuple[Int32Array, Tensor]:
        """Keys (B, 3) of the blocks in use, sorted, and their buffer rows (B,)."""
        hashmap = self.grid.hashmap()
        rows = hashmap.active_buf_indices().to(o3c.int64)
        keys = hashmap.key_tensor()[rows].cpu().numpy()
        order = np.lexsort(keys.T[::-1])
        return keys[order], torch.utils.dlpack.from_dlpack(rows.to_dlpack())[self._tensor(order)]

    def select(self, rows: Tensor, keep: Callable[..., Tensor], *names: str) -> Tensor:
        """Addresses, in order, of the voxels of the given blocks where `keep` holds; `keep` is called with the
        named attributes of whole blocks, (B, 4096, channels) each, and returns (B, 4096) bool."""
        whole = [self.attribute(name).unflatten(0, (-1, BLOCK_VOXELS))[rows] for name in names]
        row, place = torch.nonzero(keep(*whole), as_tuple=True)
        return rows[row] * BLOCK_VOXELS + place

    def surface_addresses(self, block_keys: Int32Array | None = None) -> Tensor:
        """Addresses, in order, of the voxels that hold the zero crossing, of the given blocks or of all."""
        return self.surface_in(self.active_rows()[1] if block_keys is None else self.rows_of(block_keys))

    def surface_in(self, rows: Tensor) -> Tensor:
        """The same for blocks given by their buffer rows (B,)."""
        min_weight, max_tsdf = self.settings.surface_weight, SURFACE_VOXELS / self.settings.truncation_voxels

        def on_surface(weight: Tensor, tsdf: Tensor) -> Tensor:
            return ((weight >= min_weight) & (tsdf.abs() <= max_tsdf))[..., 0]

        parts = [self.select(part, on_surface, "weight", "tsdf") for part in rows.split(BLOCKS_AT_ONCE)]
        return torch.cat(parts)

    def take_touched(self) -> Tensor | None:
        """Buffer rows (B,), in order, of the blocks of which any attribute was changed since this was last asked;
        None = any may have been."""
        self._touch(torch.zeros(0, dtype=torch.int64, device=self.torch_device))
        touched = None if self._touched is None else torch.nonzero(self._touched).squeeze(1)
        self._touched = torch.zeros(int(self.grid.hashmap().capacity()), dtype=torch.bool, device=self.torch_device)
        return touched

    def settle(self) -> None:
        """Carry all fusions and prunings through to every voxel, so that labels can be read directly."""
        for rows in self.active_rows()[1].split(BLOCKS_AT_ONCE):
            claimed = self.select(rows, lambda counts: (counts > 0).any(dim=2), "counts")
            self.relabel(claimed)
