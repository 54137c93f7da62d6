"""DBSCAN (Ester et al. 1996) of many point sets on one voxel lattice, exactly and at once.

On a lattice the neighbours within epsilon stand at a fixed list of offsets. Cells are laid out block by block, each
block with a halo of its neighbours' cells, so that a neighbour is one look-up at a constant distance. The sets (one
for each mask, and masks may overlap) are kept apart by comparing set numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from razer.arrays import BoolArray, IndexArray, Int32Array, IntArray
from razer.detection.observed_surface import BLOCK, Cells

Pairs = tuple[IndexArray, IndexArray]
SHIFTS = np.array(list(product((-1, 0, 1), repeat=3)))


def cluster(
    cells: Cells, member_set: Int32Array, member_cell: Int32Array, radius: float, min_points: int
) -> Int32Array:
    """Cluster label (M,) of each member, -1 = noise; labels are unique over all sets.

    A border point goes to its core neighbour that comes first.

    Args:
        cells: The C lattice cells that the sets are made of.
        member_set: The set (M,) of each member.
        member_cell: The cell (M,) of each member, increasing; a cell may be a member of several sets.
        radius: DBSCAN's epsilon, in units of the lattice.
        min_points: Neighbours within it that make a core point, itself included.

    Raises:
        ValueError: The radius reaches beyond the adjacent block.
    """
    count = len(member_set)
    near, far = _neighbours(cells, member_set, member_cell, radius)
    degree = np.ones(count, np.intp)
    for rows in (*near, *far):
        degree += np.bincount(rows, minlength=count)
    core = degree >= min_points
    labels = _components(member_set, core, near, far)
    _adopt_borders(labels, core, np.concatenate([near[0], far[0]]), np.concatenate([near[1], far[1]]))
    return labels


def _components(member_set: Int32Array, core: BoolArray, near: Pairs, far: Pairs) -> Int32Array:
    """Connected component of each core member, -1 for the others.

    Cells that share a face join nearly everything; the other pairs matter only where a set has several components.
    """
    label = _connected(len(core), *_both_core(core, near))
    components = np.unique(label[core])
    if len(components) > len(np.unique(member_set[core])):
        a, b = (label.take(rows) for rows in _both_core(core, far))
        bridges = np.flatnonzero(a != b)
        label = _connected(len(core), a[bridges], b[bridges]).take(label)
    return np.where(core, label, -1).astype(np.int32)


def _both_core(core: BoolArray, pairs: Pairs) -> Pairs:
    if core.all():
        return pairs
    both = np.flatnonzero(core.take(pairs[0]) & core.take(pairs[1]))
    return pairs[0].take(both), pairs[1].take(both)


def _connected(count: int, first: IntArray, second: IntArray) -> Int32Array:
    graph = coo_array((np.ones(len(first), np.int8), (first, second)), shape=(count, count))
    labels: Int32Array = connected_components(graph, directed=False)[1]
    return labels


def _adopt_borders(labels: Int32Array, core: BoolArray, first: IndexArray, second: IndexArray) -> None:
    """Give each member that is no core point the label of its first core neighbour, if it has one."""
    if core.all():
        return
    core_first, core_second = core.take(first), core.take(second)
    reaches, reached = np.flatnonzero(core_second > core_first), np.flatnonzero(core_first > core_second)
    border = np.concatenate([first[reaches], second[reached]])
    neighbour = np.concatenate([second[reaches], first[reached]])
    order = np.lexsort((neighbour, border))
    adopted, start = np.unique(border[order], return_index=True)
    labels[adopted] = labels[neighbour[order][start]]


def _neighbours(cells: Cells, member_set: Int32Array, member_cell: Int32Array, radius: float) -> tuple[Pairs, Pairs]:
    """Pairs of members of one set within the radius, each once: those in cells that share a face, and the others."""
    halo = int(radius)
    if halo >= BLOCK:
        raise ValueError(f"a radius of {radius} voxels reaches beyond the adjacent block")
    layout = HaloLayout.of(cells, member_cell, halo)
    offsets, n_faces = _half_ball(radius, layout.side)
    # A last set that equals no other stands for "no member": it is what -1 looks up.
    sets = np.append(member_set, -1)
    table = np.full(layout.size, -1, np.int32)
    near: list[Pairs] = []
    far: list[Pairs] = []

    def search(rows: IndexArray, steps: list[int], into: list[Pairs]) -> None:
        address, own = layout.home.take(rows), member_set.take(rows)
        for step in steps:
            neighbour = table.take(address + step)
            same = np.flatnonzero(sets.take(neighbour, mode="wrap") == own)
            into.append((rows.take(same), neighbour.take(same).astype(np.intp)))

    layers = _layers(member_cell)
    for i, layer in enumerate(layers):
        place, row = layout.places(layer)
        table[place] = row
        search(layer, offsets[:n_faces], near)
        search(layer, offsets[n_faces:], far)
        for higher in layers[i + 1 :]:
            search(higher, [*offsets, *(-step for step in offsets)], far)
        table[place] = -1
    return _joined(near), _joined(far)


def _joined(pairs: list[Pairs]) -> Pairs:
    nothing = np.zeros(0, np.intp)
    first = np.concatenate([nothing, *(a for a, _ in pairs)])
    return first, np.concatenate([nothing, *(b for _, b in pairs)])


def _layers(member_cell: Int32Array) -> list[IndexArray]:
    """Rows of the members, spread over layers in which each cell has at most one."""
    starts = np.flatnonzero(np.diff(member_cell, prepend=-1))
    depth = np.arange(len(member_cell)) - np.repeat(starts, np.diff(starts, append=len(member_cell)))
    return [np.flatnonzero(depth == level) for level in range(int(depth.max(initial=-1)) + 1)]


@dataclass(frozen=True, slots=True)
class HaloLayout:
    """Where members stand in an array of blocks with halos: `side` cells along each edge of a block, `size` places
    in all, `home` (M,) the place of each member, `copies` (n,) places in the halos of other blocks and `copied`
    (n,) the members that are repeated there."""

    side: int
    size: int
    home: IndexArray
    copies: IndexArray
    copied: IndexArray

    @classmethod
    def of(cls, cells: Cells, member_cell: Int32Array, halo: int) -> HaloLayout:
        """Lay out the members of `cells` with halos as wide as the search reaches."""
        side = BLOCK + 2 * halo
        step = np.array([side * side, side, 1])
        block, local = cells.block.take(member_cell).astype(np.intp), cells.local.take(member_cell).astype(np.intp)
        inside = np.stack([local % BLOCK, local // BLOCK % BLOCK, local // BLOCK**2], axis=1)
        home = block * side**3 + (inside + halo) @ step
        adjacent = _adjacent_blocks(cells.block_keys)
        reaches = np.stack([inside < halo, np.ones(inside.shape, bool), inside >= BLOCK - halo])  # by -1, 0, +1
        nothing = np.zeros(0, np.intp)
        copies, copied = [nothing], [nothing]
        for i, (x, y, z) in enumerate(SHIFTS):
            at = np.flatnonzero(reaches[x + 1, :, 0] & reaches[y + 1, :, 1] & reaches[z + 1, :, 2])
            target = adjacent.take(block.take(at) * len(SHIFTS) + i)
            at, target = at[target >= 0], target[target >= 0]
            if x or y or z:
                copies.append(home.take(at) + (target - block.take(at)) * side**3 - BLOCK * int(SHIFTS[i] @ step))
                copied.append(at)
        return cls(side, len(cells.block_keys) * side**3, home, np.concatenate(copies), np.concatenate(copied))

    def places(self, rows: IndexArray) -> tuple[IndexArray, IndexArray]:
        """All places of the given members, and the member at each."""
        chosen = np.zeros(len(self.home), bool)
        chosen[rows] = True
        repeated = np.flatnonzero(chosen.take(self.copied))
        place = np.concatenate([self.home.take(rows), self.copies.take(repeated)])
        return place, np.concatenate([rows, self.copied.take(repeated)])


def _adjacent_blocks(keys: Int32Array) -> IndexArray:
    """Row of the block at each of the 27 shifts of each block, flat (B * 27,); -1 where there is none."""
    low = keys.min(axis=0, initial=0) - 1
    shape = keys.max(axis=0, initial=0) - low + 2
    dense = np.full(tuple(shape), -1, np.intp)
    dense[tuple((keys - low).T)] = np.arange(len(keys))
    return dense[tuple(np.moveaxis(keys[:, None] + SHIFTS - low, -1, 0))].ravel()


@lru_cache(maxsize=8)
def _half_ball(radius: float, side: int) -> tuple[list[int], int]:
    """Half of the offsets within the radius as distances in a row-major cube, nearest first, and how many of them
    lead to a cell that shares a face."""
    reach = range(-int(radius), int(radius) + 1)
    inside = [o for o in product(reach, repeat=3) if o > (0, 0, 0) and np.dot(o, o) <= radius**2 + 1e-9]
    inside.sort(key=lambda o: int(np.dot(o, o)))
    return [(x * side + y) * side + z for x, y, z in inside], sum(np.dot(o, o) == 1 for o in inside)
