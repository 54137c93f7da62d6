"""TSDF volume with label histograms, V(p) = {d, w, c, l, h} (RAZER eq. 1), over pages of Open3D's VoxelBlockGrid, on
the CPU or a CUDA device.

Attribute tensors are shared with torch by DLPack. Everything host-side that is not a whole attribute (cell
addresses, per-instance counts) travels freely; attributes themselves leave the device in
`razer.volume.mesh_extraction` and `razer.storage` only.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import open3d.core as o3c
import torch
from numpy.typing import NDArray
from torch import Tensor

from razer.arrays import BoolArray, Int32Array
from razer.config import VoxelSettings
from razer.detection.observed_surface import BLOCK_VOXELS, Cells, ObservedSurface
from razer.frame import Frame
from razer.volume import label_histogram
from razer.volume.blocks.block_pages import BLOCKS_AT_ONCE, BlockPages
from razer.volume.frame_fusion import FrameFusion
from razer.volume.id_remap import InstanceIdMap, numbered
from razer.volume.surface_evidence import is_observed_enough

SURFACE_VOXELS = 0.75  # a voxel this near to the zero crossing holds surface


class VoxelMap:
    """Truncated signed distances with colours, and for each voxel its instance and a histogram of labels."""

    def __init__(self, settings: VoxelSettings, device: str = "CPU:0", id_map: InstanceIdMap | None = None) -> None:
        """An empty volume.

        Args:
            settings: Voxel size, truncation distance, depth range and histogram slots.
            device: As Open3D names it, "CPU:0" or "CUDA:0".
            id_map: Shared with another volume of the same instances; by default a new one.
        """
        self.settings = settings
        self.device = o3c.Device(device)
        self.torch_device = torch.device("cuda" if device.upper().startswith("CUDA") else "cpu")
        self.pages = BlockPages(settings, self.device, self.torch_device)
        self._fusion = FrameFusion(self.pages, settings, self.device)
        # Fused instances: voxels keep the old id until next touched, and are read through this table.
        self._id_map = id_map or InstanceIdMap(self.torch_device)
        self._touched: Tensor | None = None  # which rows, None = any

    def __getstate__(self) -> dict[str, Any]:
        return {
            "settings": self.settings,
            "device": str(self.device),
            "id_map": self._id_map,
            "blocks": self.pages.contents(),
            "touched": self._touched,
            "colorless": self._fusion.colorless,
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(state["settings"], state["device"], state["id_map"])  # type: ignore[misc]
        has_same_rows = self.pages.fill(state["blocks"])
        self._touched = state["touched"] if has_same_rows else None
        self._fusion.colorless = state["colorless"]

    def empty_copy(self) -> VoxelMap:
        """An empty volume of the same kind, for the same instances: fusions and prunings of one hold in both."""
        return VoxelMap(self.settings, str(self.device), self._id_map)

    @property
    def n_blocks(self) -> int:
        """Blocks of 16^3 voxels in use."""
        return len(self.pages)

    @property
    def newest_id(self) -> int:
        """The largest id admitted so far."""
        return self._id_map.newest_id

    @property
    def memory_bytes(self) -> int:
        """Bytes the attributes take, with those of blocks for which there is room."""
        return self.pages.memory_bytes

    def integrate(self, frame: Frame, surface: ObservedSurface | None = None) -> Int32Array:
        """Fuse a posed frame, of which the observed `surface` may be known already; returns the sorted keys
        (M, 3) of the blocks within the truncation distance of it. Raises UnusableFrame without depth in range.
        """
        s = self.settings
        if surface is None:
            surface = ObservedSurface.of(frame, s.voxel_size_m, s.depth_min_m, s.depth_max_m)
        block_keys = surface.blocks_within(s.truncation_m)
        self.pages.add(block_keys)
        self._fusion.fuse(frame, block_keys)
        self._touch(self.rows_of(block_keys))
        return block_keys

    def _touch(self, rows: Tensor) -> None:
        if self._touched is not None:
            self._touched = self._grown(self._touched)
            self._touched[rows] = True

    def _grown(self, of_rows: Tensor) -> Tensor:
        """Flags of rows (R,), with those of rows that came since."""
        n_more = self.pages.n_rows - len(of_rows)
        return torch.cat([of_rows, of_rows.new_zeros(n_more)]) if n_more else of_rows

    def allocate(self, block_keys: Int32Array) -> None:
        """Add blocks (B, 3) of empty voxels."""
        self.pages.add(block_keys)

    def _addresses(self, cells: Cells) -> tuple[Tensor, Tensor]:
        """Rows of the flat attributes for the cells the map has, and the indices of those cells."""
        row = self.pages.find(cells.block_keys)[self._tensor(cells.block)]
        known = torch.nonzero(row >= 0).squeeze(1)
        return row[known] * BLOCK_VOXELS + self._tensor(cells.local)[known], known

    def _tensor(self, values: NDArray) -> Tensor:
        return torch.from_numpy(np.ascontiguousarray(values)).to(self.torch_device, torch.int64)

    def rows_of(self, block_keys: Int32Array) -> Tensor:
        """Rows of those of the given blocks (B, 3) that the map has."""
        rows = self.pages.find(block_keys)
        return rows[rows >= 0]

    def histograms_at(self, cells: Cells) -> tuple[Tensor, Tensor]:
        """Ids and counts (C, K) of each cell's histogram, empty where the map has no such cell."""
        addresses, known = self._addresses(cells)
        shape = (len(cells), self.settings.histogram_slots)
        ids, counts = (torch.zeros(shape, dtype=torch.int64, device=self.torch_device) for _ in range(2))
        known_ids, known_counts = self.pages.read(addresses, "ids", "counts")
        ids[known], counts[known] = self.resolve(known_ids).long(), known_counts.long()
        return ids, counts

    def resolve(self, ids: Tensor) -> Tensor:
        """Ids after all fusions and prunings so far."""
        return self._id_map.resolve(ids)

    def labels_at(self, cells: Cells) -> Tensor:
        """The label (C,) int32 of each cell, 0 = nobody; stays on the device."""
        addresses, known = self._addresses(cells)
        result = torch.zeros(len(cells), dtype=torch.int32, device=self.torch_device)
        result[known] = self.resolve(self.pages.read(addresses, "label")[0][:, 0])
        return result

    def count_labels(self, labels: Tensor, group: Int32Array, cell: Int32Array) -> dict[tuple[int, int], int]:
        """How many cells of each group bear each label: {(group, id): cells}, nobody left out.

        group (M,) and cell (M,) list the members of all groups; `labels` is from `labels_at`.
        """
        ids, number = numbered(labels, self.newest_id)
        counts = torch.bincount(self._tensor(group) * len(ids) + number[self._tensor(cell)])
        bins = torch.nonzero(counts).squeeze(1)
        known = ids.tolist()
        table = ((*divmod(row, len(known)), n) for row, n in zip(bins.tolist(), counts[bins].tolist(), strict=True))
        return {(row, known[column]): n for row, column, n in table if known[column]}

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
        stored_ids, counts = (part.T.contiguous() for part in self.pages.read(addresses, "ids", "counts"))
        ids = self.resolve(stored_ids)
        stale = torch.nonzero((ids != stored_ids).any(dim=0)).squeeze(1)
        ids[:, stale], counts[:, stale] = label_histogram.merge_equal(ids[:, stale], counts[:, stale])
        ids, counts = change(ids, counts)
        self._touch(addresses // BLOCK_VOXELS)
        label = label_histogram.winner(ids, counts)
        self.pages.write(addresses, ids=ids.T.contiguous(), counts=counts.T.contiguous(), label=label[:, None])

    def amplify(self, times: float) -> None:
        """Let every observation and vote so far count `times` times."""
        self._touched = None
        for weight in self.pages.views("weight"):
            weight.mul_(times)
        for counts in self.pages.views("counts"):
            counts.copy_((counts * times).round_().clamp_(max=label_histogram.MAX_COUNT))

    def surface_addresses(self, block_keys: Int32Array | None = None) -> Tensor:
        """Addresses, in order, of the voxels that hold the zero crossing, of the given blocks or of all."""
        return self.surface_in(self.pages.all()[1] if block_keys is None else self.rows_of(block_keys))

    def surface_in(self, rows: Tensor) -> Tensor:
        """The same for blocks given by their rows (B,)."""
        max_tsdf = SURFACE_VOXELS / self.settings.truncation_voxels

        def on_surface(weight: Tensor, tsdf: Tensor) -> Tensor:
            return is_observed_enough(weight[..., 0], self.settings) & (tsdf[..., 0].abs() <= max_tsdf)

        return self.pages.select(rows, on_surface, "weight", "tsdf")

    def take_touched(self) -> Tensor | None:
        """Rows (B,), in order, of the blocks of which any attribute was changed since this was last asked; None = any
        may have been."""
        touched = None if self._touched is None else torch.nonzero(self._touched).squeeze(1)
        self._touched = torch.zeros(self.pages.n_rows, dtype=torch.bool, device=self.torch_device)
        return touched

    def settle(self) -> None:
        """Carry all fusions and prunings through to every voxel, so that labels can be read directly."""
        for rows in self.pages.all()[1].split(BLOCKS_AT_ONCE):
            self.relabel(self.pages.select(rows, lambda counts: (counts > 0).any(dim=2), "counts"))
