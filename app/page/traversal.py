"""Breadth-first traversal of a triangle mesh, after which most of its connectivity need not be written down.

Each triangle but the first of a component hangs on an edge of an earlier one, its parent, so that only its third corner
says anything; parents never step back, and new vertices come in the order of their first use. As in Edgebreaker
(Rossignac, 1999) a triangle then costs a few bits, but the order comes from SciPy's graph search and needs no loop.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components

from razer.arrays import BoolArray, IntArray

ROOT = 3  # instead of the number of an edge


@dataclass(frozen=True)
class Traversal:
    """The T triangles in their new order: corners (T, 3), vertices by first use, in which the first two are the ends
    of `edge` (T,) of the triangle at rank `parent` (T,), turned round; ROOT and -1 for those without a parent. vertices
    (V,): which vertex of the mesh is the n-th; is_first (T, 3): whether a corner is its vertex's first use."""

    corners: IntArray
    parent: IntArray
    edge: IntArray
    vertices: IntArray
    is_first: BoolArray

    @property
    def is_root(self) -> BoolArray:
        """Whether a triangle (T,) has no parent."""
        return self.edge == ROOT


def traverse(triangles: IntArray) -> Traversal:
    """The traversal of triangles (T, 3); vertices of no triangle are not in it."""
    triangles = triangles.astype(np.int64)
    n = len(triangles)
    order, parent_triangle = _breadth_first(triangles)
    rank = np.full(n + 1, -1)
    rank[order] = np.arange(n)
    parent = rank[parent_triangle]
    corners, turn, edge = _hung(triangles[order], triangles[np.where(parent < 0, 0, parent_triangle)], parent < 0)
    edge = np.where(parent < 0, ROOT, (edge - turn[parent]) % 3)
    used, first = np.unique(corners, return_index=True)
    vertices = used[np.argsort(first)]
    number = np.empty(int(triangles.max(initial=-1)) + 1, np.int64)
    number[vertices] = np.arange(len(vertices))
    is_first = np.zeros(3 * n, bool)
    is_first[first] = True
    return Traversal(number[corners], parent, edge, vertices, is_first.reshape(n, 3))


def _breadth_first(triangles: IntArray) -> tuple[IntArray, IntArray]:
    """The triangles in order, and of each the triangle that it hangs on; T for those that hang on none."""
    n = len(triangles)
    size = int(triangles.max(initial=-1)) + 1
    start, end = triangles.reshape(-1), np.roll(triangles, -1, axis=1).reshape(-1)
    key, turned = start * size + end, end * size + start
    by_key = np.argsort(key, kind="stable")
    place = np.searchsorted(key[by_key], turned).clip(max=max(len(key) - 1, 0))
    half = np.flatnonzero(key[by_key[place]] == turned)
    one, other = half // 3, by_key[place[half]] // 3
    _, component = connected_components(_graph(one, other, n), directed=False)
    _, roots = np.unique(component, return_index=True)
    # One more node on which all components hang; of edges with three triangles one direction may be missing.
    rows, columns = np.concatenate([one, np.full(len(roots), n)]), np.concatenate([other, roots])
    reached, hangs_on = breadth_first_order(_graph(rows, columns, n + 1), n)
    missing = np.setdiff1d(np.arange(n), reached)
    order = np.concatenate([reached[1:], missing]).astype(np.int64)
    parent = np.where(np.isin(order, missing), n, hangs_on[order]) if len(missing) else hangs_on[order]
    return order, parent.astype(np.int64)


def _graph(rows: IntArray, columns: IntArray, size: int) -> csr_matrix:
    return csr_matrix((np.ones(len(rows), np.int8), (rows, columns)), shape=(size, size))


def _hung(children: IntArray, parents: IntArray, is_root: BoolArray) -> tuple[IntArray, IntArray, IntArray]:
    """The children (T, 3) turned so that their first two corners are those of an edge of their parents (T, 3), by how
    much, and which edge that is."""
    edge, turn = np.full(len(children), -1), np.zeros(len(children), np.int64)
    for of_parent in range(3):
        for of_child in range(3):
            starts = parents[:, of_parent] == children[:, (of_child + 1) % 3]
            ends = parents[:, (of_parent + 1) % 3] == children[:, of_child]
            fits = starts & ends & (edge < 0) & ~is_root
            edge[fits], turn[fits] = of_parent, of_child
    turned = (turn[:, None] + np.arange(3)) % 3
    return np.take_along_axis(children, turned, axis=1), turn, edge
