"""DBSCAN (Ester et al. 1996) of many point sets on one voxel lattice, exactly and at once.

On a lattice the neighbours within epsilon stand at a fixed list of offsets, so that every pair of neighbouring
cells is found by array look-ups; the sets (one for each mask, and masks may overlap) then only select pairs.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from razer.cells import BLOCK, BLOCK_VOXELS, Cells

Ints = NDArray[np.int32]


def cluster(cells: Cells, member_set: Ints, member_cell: Ints, radius: float, min_points: int) -> Ints:
    """Cluster label (M,) of each member, -1 = noise; labels are unique over all sets.

    Member m is cell `member_cell[m]` in set `member_set[m]`, sorted by cell; `radius` is epsilon in units of
    the lattice; a core point has at least `min_points` neighbours, itself included. A border point goes to
    its core neighbour that comes first.
    """
    count = len(member_set)
    first, second = _member_pairs(cells, member_set, member_cell, radius)
    degree = 1 + np.bincount(first, minlength=count) + np.bincount(second, minlength=count)
    core = degree >= min_points
    core_first, core_second = core[first], core[second]
    both = np.flatnonzero(core_first & core_second)
    labels = np.where(core, _components(count, first[both], second[both]), -1).astype(np.int32)
    reaches, reached = np.flatnonzero(core_second > core_first), np.flatnonzero(core_first > core_second)
    border = np.concatenate([first[reaches], second[reached]])
    neighbour = np.concatenate([second[reaches], first[reached]])
    order = np.lexsort((neighbour, border))
    found, start = np.unique(border[order], return_index=True)
    labels[found] = labels[neighbour[order][start]]
    return labels


def _components(count: int, first: Ints, second: Ints) -> Ints:
    """Connected component (count,) of each node. The nearest neighbours come first and join nearly everything:
    of the remaining pairs only those between two components are looked at."""
    near = len(first) // 3
    label = _connected(count, first[:near], second[:near])
    a, b = label[first[near:]], label[second[near:]]
    bridges = a != b
    return _connected(count, a[bridges], b[bridges])[label] if bridges.any() else label


def _connected(count: int, first: Ints, second: Ints) -> Ints:
    graph = coo_array((np.ones(len(first), np.int8), (first, second)), shape=(count, count))
    labels: Ints = connected_components(graph, directed=False)[1]
    return labels


def _member_pairs(cells: Cells, member_set: Ints, member_cell: Ints, radius: float) -> tuple[Ints, Ints]:
    """Pairs of members of one set within the radius, each pair once."""
    first_cell, second_cell = neighbour_pairs(cells, radius)
    layers = _layers(len(cells), member_set, member_cell)
    pairs = []
    for i, (sets_a, members_a) in enumerate(layers):
        for j, (sets_b, members_b) in enumerate(layers):
            # Few cells are in the higher layers: only pairs with a cell there need a look.
            first, second = first_cell, second_cell
            if i or j:
                there = np.flatnonzero(sets_b[second] >= 0 if j >= i else sets_a[first] >= 0)
                first, second = first[there], second[there]
            owner = sets_a[first]
            same = np.flatnonzero((owner == sets_b[second]) & (owner >= 0))
            pairs.append((members_a[first[same]], members_b[second[same]]))
    if not pairs:
        return np.zeros(0, np.int32), np.zeros(0, np.int32)
    return np.concatenate([a for a, _ in pairs]), np.concatenate([b for _, b in pairs])


def _layers(n_cells: int, member_set: Ints, member_cell: Ints) -> list[tuple[Ints, Ints]]:
    """Members spread over layers in which each cell has at most one: (set or -1, member) per cell."""
    if len(member_cell) == 0:
        return []
    starts = np.flatnonzero(np.r_[True, member_cell[1:] != member_cell[:-1]])
    depth = np.arange(len(member_cell)) - np.repeat(starts, np.diff(np.r_[starts, len(member_cell)]))
    layers = []
    for level in range(int(depth.max()) + 1):
        here = np.flatnonzero(depth == level).astype(np.int32)
        sets, members = np.full(n_cells, -1, np.int32), np.zeros(n_cells, np.int32)
        sets[member_cell[here]] = member_set[here]
        members[member_cell[here]] = here
        layers.append((sets, members))
    return layers


def neighbour_pairs(cells: Cells, radius: float) -> tuple[Ints, Ints]:
    """All pairs (a, b) of cells at most `radius` lattice units apart, each pair once."""
    table = np.full((len(cells.block_keys) + 1) * BLOCK_VOXELS, -1, np.int32)
    table[cells.block * BLOCK_VOXELS + cells.local] = np.arange(len(cells), dtype=np.int32)
    adjacent = _adjacent_blocks(cells.block_keys)
    shift_of, local_of = _offset_tables(radius)
    # numpy looks up by intp; anything else it would convert each time.
    block_row, local = cells.block.astype(np.intp) * 27, cells.local.astype(np.intp)
    first, second = [], []
    for shifts, locals_ in zip(shift_of, local_of, strict=True):
        other = table[adjacent[block_row + shifts[local]] * BLOCK_VOXELS + locals_[local]]
        found = np.flatnonzero(other >= 0)
        first.append(found.astype(np.int32))
        second.append(other[found])
    return np.concatenate(first), np.concatenate(second)


def _adjacent_blocks(keys: Ints) -> NDArray[np.intp]:
    """Row of the block at each of 27 shifts of each block, flat (B * 27,); B where there is none."""
    low = keys.min(axis=0, initial=0) - 1
    shape = keys.max(axis=0, initial=0) - low + 2
    dense = np.full(tuple(shape), len(keys), np.intp)
    dense[tuple((keys - low).T)] = np.arange(len(keys))
    shifts = np.array(list(product((-1, 0, 1), repeat=3)))
    return dense[tuple(np.moveaxis(keys[:, None] + shifts - low, -1, 0))].ravel()


@lru_cache(maxsize=8)
def _offset_tables(radius: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """For half of the offsets within the radius, nearest first: block shift (O, 4096), new place (O, 4096)."""
    if radius >= BLOCK:
        raise ValueError(f"a radius of {radius} voxels reaches beyond the adjacent block")
    reach = range(-int(radius), int(radius) + 1)
    inside = [o for o in product(reach, repeat=3) if o > (0, 0, 0) and np.dot(o, o) <= radius**2 + 1e-9]
    places = np.arange(BLOCK_VOXELS)
    xyz = np.stack([places % BLOCK, places // BLOCK % BLOCK, places // BLOCK**2], axis=1)
    moved = xyz + np.array(inside)[:, None]
    shift = (moved // BLOCK + 1) @ np.array([9, 3, 1])
    return shift, moved % BLOCK @ np.array([1, BLOCK, BLOCK**2])
