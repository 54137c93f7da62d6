"""Pages of voxel blocks: as many small VoxelBlockGrids as the map needs, each of a fixed capacity.

One grid that grows copies all that it holds, for seconds; here nothing is ever copied, and views stay valid. A voxel's
address is page * capacity * 4096 + row * 4096 + place, so that addresses of all pages can be mixed freely.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
import open3d as o3d
import open3d.core as o3c
import torch
from numpy.typing import NDArray
from torch import Tensor

from razer.arrays import Int32Array, Int64Array
from razer.config import VoxelSettings
from razer.detection.observed_surface import BLOCK, BLOCK_VOXELS
from razer.volume.blocks.block_index import BlockIndex

# Blocks of a page. Larger: a page takes the longer to make (100 MB take some 0.15 s), and more stay unused; smaller: a
# frame meets more pages, each with its own call.
PAGE_BLOCKS = 512
# Rows of a page beyond its blocks. Open3D's `integrate` makes room for all blocks that it is given, new or not, and so
# is given no more at once; fewer than 16 cost time.
SPARE_ROWS = 16
# On CUDA a call costs 0.15 ms of waiting, however few the blocks: a frame of 314 took 5.5 ms with 16, 3.9 with 64 and
# 3.7 with 128 on an H100.
CUDA_SPARE_ROWS = 64
BLOCKS_AT_ONCE = 128  # of passes over many blocks, to bound their memory
PIECE_BLOCKS = 32  # of a checkpoint: what changed since the last one is written piece by piece
_CHANNELS = {"tsdf": 1, "weight": 1, "color": 3, "label": 1}
_TYPES = {"tsdf": o3c.float32, "weight": o3c.float32, "color": o3c.float32, "label": o3c.int32}


class BlockPages:
    """Attributes of voxels in blocks of 16^3, by address, and the blocks by their keys."""

    def __init__(self, settings: VoxelSettings, device: o3c.Device, torch_device: torch.device) -> None:
        self._voxel_size_m = settings.voxel_size_m
        self.device, self._torch_device = device, torch_device
        slots = settings.histogram_slots
        self._channels = {**_CHANNELS, "ids": slots, "counts": slots}
        self._types = {**_TYPES, "ids": o3c.int32, "counts": o3c.int16}
        self._spare_rows = CUDA_SPARE_ROWS if torch_device.type == "cuda" else SPARE_ROWS
        self._page_blocks, self.page_rows = PAGE_BLOCKS, PAGE_BLOCKS + self._spare_rows
        self._index = BlockIndex()
        self._grids: list[o3d.t.geometry.VoxelBlockGrid] = []
        self._keys = torch.zeros((0, 3), dtype=torch.int32, device=torch_device)

    def __len__(self) -> int:
        """Blocks in use."""
        return len(self._index)

    @property
    def n_rows(self) -> int:
        """Rows of all pages: one more than the largest that a block can have now."""
        return len(self._grids) * self.page_rows

    @property
    def memory_bytes(self) -> int:
        """Bytes the attributes of all pages take."""
        return sum(view.nbytes for name in self._channels for view in self.views(name))

    def add(self, block_keys: Int32Array) -> None:
        """Make room for those of the blocks (B, 3) that are missing, with empty voxels. Raises UnusableFrame for blocks
        too far from the others."""
        missing = self._index.missing(block_keys)
        while len(missing):
            room = len(self._grids) * self._page_blocks - len(self)
            if not room:
                self._open_page()
                continue
            self._fill(missing[:room])
            missing = missing[room:]

    def _open_page(self) -> None:
        names = tuple(self._channels)
        shapes = tuple(o3c.SizeVector([n]) for n in self._channels.values())
        grid = o3d.t.geometry.VoxelBlockGrid(
            names,
            tuple(self._types[name] for name in names),
            shapes,
            self._voxel_size_m,
            BLOCK,
            self.page_rows,
            self.device,
        )
        self._grids.append(grid)
        self._keys = torch.cat([self._keys, self._keys.new_zeros((self.page_rows, 3))])

    def _fill(self, block_keys: Int32Array) -> None:
        hashmap, keys = self._grids[-1].hashmap(), self._on_device(block_keys)
        hashmap.activate(keys)
        rows = shared(hashmap.find(keys)[0].to(o3c.int64)) + (len(self._grids) - 1) * self.page_rows
        self._keys[rows] = shared(keys)
        self._index.add(block_keys, np.array(rows.tolist(), np.int64))

    def contents(self) -> list[dict[str, NDArray]]:
        """All blocks in the order of their rows, `PIECE_BLOCKS` at a time: `keys` (B, 3) and `rows` (B,) of theirs,
        and each attribute (B, 4096, channels) by its name. Where rows follow each other, as they do on the CPU, these
        are no copies."""
        keys, rows = self._index.all()
        order = np.argsort(rows)
        ends = np.searchsorted(rows[order], self.page_rows * np.arange(1, len(self._grids)))
        return [
            self._piece(page, keys[some], rows[some])
            for page, of_page in enumerate(np.split(order, ends))
            for some in np.split(of_page, range(PIECE_BLOCKS, len(of_page), PIECE_BLOCKS))
        ]

    def _piece(self, page: int, keys: Int32Array, rows: Int64Array) -> dict[str, NDArray]:
        """Blocks (B,) of one page, with what they hold."""
        local = self._rows(rows - page * self.page_rows)
        first, n = int(local[0]), len(local)
        is_run = bool((local == torch.arange(first, first + n, device=local.device)).all())
        piece: dict[str, NDArray] = {"keys": keys, "rows": rows}
        for name in self._channels:
            whole = self._view(page, name).unflatten(0, (-1, BLOCK_VOXELS))
            piece[name] = (whole[first : first + n] if is_run else whole.index_select(0, local)).cpu().numpy()
        return piece

    def fill(self, contents: Sequence[Mapping[str, NDArray]]) -> bool:
        """Take in what `contents` gave, into pages that are empty; returns whether all blocks got the rows that they
        had, as they do on the CPU."""
        same = True
        for piece in contents:
            for key in piece["keys"]:  # one by one: among several at once, Open3D hands out rows in any order
                self.add(key[None])
            rows = self.find(piece["keys"])
            same &= rows.tolist() == piece["rows"].tolist()
            columns = {name: self._tensor(piece[name]).flatten(0, 1) for name in self._channels}
            self.write(addresses_in(rows, torch.ones((len(rows), BLOCK_VOXELS), dtype=torch.bool)), **columns)
        return same

    def _tensor(self, values: NDArray) -> Tensor:
        return torch.from_numpy(values).to(self._torch_device)

    def _on_device(self, block_keys: Int32Array) -> o3c.Tensor:
        return o3c.Tensor(np.ascontiguousarray(block_keys, dtype=np.int32)).to(self.device)

    def _rows(self, rows: Int64Array) -> Tensor:
        return torch.from_numpy(rows).to(self._torch_device)

    def find(self, block_keys: Int32Array) -> Tensor:
        """The row (B,) int64 of each block (B, 3), -1 where there is none."""
        return self._rows(self._index.find(block_keys))

    def all(self) -> tuple[Int32Array, Tensor]:
        """Keys (B, 3) of the blocks in use, sorted, and their rows (B,)."""
        keys, rows = self._index.all()
        return keys, self._rows(rows)

    def within(self, low: Int32Array, high: Int32Array) -> tuple[Int32Array, Tensor]:
        """The same for the blocks in a box from `low` to `high` (3,), both included."""
        keys, rows = self._index.within(low, high)
        return keys, self._rows(rows)

    def positions(self, addresses: Tensor) -> Tensor:
        """World positions (N, 3) float32 metres of voxels."""
        place = addresses % BLOCK_VOXELS
        inside = torch.stack([place % BLOCK, place // BLOCK % BLOCK, place // BLOCK**2], dim=1)
        lattice = self._keys[addresses // BLOCK_VOXELS] * BLOCK + inside
        return lattice.float() * self._voxel_size_m

    def _by_page(self, places: Tensor, page_size: int) -> Iterator[tuple[int, Tensor, Tensor]]:
        """The number of each page that has any of the places (N,), which of them it has, and where in it."""
        page = torch.div(places, page_size, rounding_mode="floor")
        for number in torch.nonzero(torch.bincount(page, minlength=1)).squeeze(1).tolist():
            here = torch.nonzero(page == number).squeeze(1)
            yield number, here, places[here] - number * page_size

    def read(self, addresses: Tensor, *names: str) -> list[Tensor]:
        """The named attributes (N, channels) of voxels at addresses (N,)."""
        columns = [self._empty(name, len(addresses)) for name in names]
        for page, here, local in self._by_page(addresses, self.page_rows * BLOCK_VOXELS):
            for name, column in zip(names, columns, strict=True):
                column.index_copy_(0, here, self._view(page, name).index_select(0, local))
        return columns

    def _empty(self, name: str, n: int) -> Tensor:
        dtype = {o3c.float32: torch.float32, o3c.int32: torch.int32, o3c.int16: torch.int16}[self._types[name]]
        return torch.empty((n, self._channels[name]), dtype=dtype, device=self._torch_device)

    def write(self, addresses: Tensor, **columns: Tensor) -> None:
        """Set the named attributes (N, channels) of voxels at addresses (N,)."""
        for page, here, local in self._by_page(addresses, self.page_rows * BLOCK_VOXELS):
            for name, column in columns.items():
                self._view(page, name).index_copy_(0, local, column.index_select(0, here))

    def mask(self, rows: Tensor, keep: Callable[..., Tensor], *names: str, n_channels: int | None = None) -> Tensor:
        """Where `keep` holds in the blocks of given rows (B,), (B, 4096) bool; it is called with the named attributes
        of some of these blocks, (b, 4096, channels) each, of which `n_channels` are read, and returns (b, 4096)."""
        held = torch.zeros((len(rows), BLOCK_VOXELS), dtype=torch.bool, device=self._torch_device)
        for page, here, local in self._by_page(rows, self.page_rows):
            held[here] = keep(*(self._whole(page, name, local, n_channels) for name in names))
        return held

    def select(self, rows: Tensor, keep: Callable[..., Tensor], *names: str, n_channels: int | None = None) -> Tensor:
        """Addresses, in order, of the voxels in blocks of given rows (B,) for which `keep` holds, as in `mask`."""
        parts = [
            addresses_in(part, self.mask(part, keep, *names, n_channels=n_channels))
            for part in rows.split(BLOCKS_AT_ONCE)
        ]
        return torch.cat(parts)

    def blocks(self, rows: Tensor, name: str) -> Tensor:
        """An attribute of the blocks of given rows (B,), (B, 4096, channels)."""
        whole = self._empty(name, len(rows) * BLOCK_VOXELS).unflatten(0, (-1, BLOCK_VOXELS))
        self.copy_blocks(rows, name, whole, torch.arange(len(rows), device=rows.device))
        return whole

    def copy_blocks(self, rows: Tensor, name: str, target: Tensor, places: Tensor) -> None:
        """Copy an attribute of the blocks of given rows (B,) to the places (B,) of a target (N, 4096, channels)."""
        for page, here, local in self._by_page(rows, self.page_rows):
            target.index_copy_(0, places[here], self._whole(page, name, local))

    def views(self, name: str) -> list[Tensor]:
        """An attribute as it is stored, (rows * 4096, channels) for each page, voxels not in use included."""
        return [self._view(page, name) for page in range(len(self._grids))]

    def _whole(self, page: int, name: str, local: Tensor, n_channels: int | None = None) -> Tensor:
        """The first channels, None = all, of an attribute of some blocks of a page, (b, 4096, channels)."""
        return self._view(page, name).unflatten(0, (-1, BLOCK_VOXELS))[..., :n_channels].index_select(0, local)

    def _view(self, page: int, name: str) -> Tensor:
        # None is kept: Open3D would count its memory as lost when the program ends.
        return shared(self._grids[page].attribute(name)).flatten(0, 3)

    def integrate(self, block_keys: Int32Array, *images_and_cameras: object) -> None:
        """Open3D's `integrate` on blocks (B, 3) that were added."""
        page = self._index.find(block_keys) // self.page_rows
        for number in np.unique(page).tolist():
            own = block_keys[page == number]
            for start in range(0, len(own), self._spare_rows):
                blocks = self._on_device(own[start : start + self._spare_rows])
                self._grids[number].integrate(blocks, *images_and_cameras)


def addresses_in(rows: Tensor, mask: Tensor) -> Tensor:
    """Addresses of the voxels of a mask (B, 4096) over blocks of given rows (B,)."""
    row, place = torch.nonzero(mask, as_tuple=True)
    return rows[row] * BLOCK_VOXELS + place


def shared(tensor: o3c.Tensor) -> Tensor:
    """The same memory as a tensor of torch."""
    return torch.utils.dlpack.from_dlpack(tensor.to_dlpack())
