"""DBSCAN on the lattice against the textbook algorithm over all pairs of points."""

from __future__ import annotations

from collections import deque

import numpy as np
import pytest

from razer.detection.dbscan import _neighbours, cluster
from razer.detection.observed_surface import cells_of
from tests.support.scenes import cells_at


def slow_dbscan(points: np.ndarray, radius: float, min_points: int) -> tuple[np.ndarray, list[set[int]]]:
    """Cluster of each core point, -1 for others; and for each point the clusters it may belong to."""
    near = [np.flatnonzero(((points - p) ** 2).sum(axis=1) <= radius**2 + 1e-9) for p in points]
    core = np.array([len(n) >= min_points for n in near])
    labels = np.full(len(points), -1)
    for start in np.flatnonzero(core):
        if labels[start] >= 0:
            continue
        labels[start] = start
        queue = deque([start])
        while queue:
            for other in near[queue.popleft()]:
                if core[other] and labels[other] < 0:
                    labels[other] = start
                    queue.append(other)
    return labels, [{int(labels[o]) for o in n if core[o]} for n in near]


def check_against_slow(points: np.ndarray, labels: np.ndarray, radius: float, min_points: int) -> None:
    """The labels of one set: same core clusters, same noise, and every border point beside its cluster."""
    expected, allowed = slow_dbscan(points, radius, min_points)
    core = expected >= 0
    assert len(set(zip(expected[core], labels[core], strict=True))) == len(set(expected[core]))
    assert len(set(labels[core])) == len(set(expected[core]))
    name = dict(zip(expected[core], labels[core], strict=True))
    for label, choices in zip(labels, allowed, strict=True):
        assert label in {name[c] for c in choices} or (not choices and label == -1)


def random_sets(seed: int, n_cells: int, n_sets: int, spread: int) -> tuple:
    """Cells around a block corner, and sets that overlap; members sorted by cell."""
    rng = np.random.default_rng(seed)
    cells, _ = cells_of(rng.integers(-spread, spread, (n_cells, 3)).astype(np.int32), 0.02)
    chosen = rng.random((len(cells), n_sets)) < 0.7
    member_cell, member_set = (a.astype(np.int32) for a in np.nonzero(chosen))
    return cells, member_set, member_cell


@pytest.mark.parametrize("radius", [1.0, 1.5, 2.0, 2.5, 3.7])
@pytest.mark.parametrize("min_points", [1, 3, 6, 10])
def test_clusters_are_those_of_the_textbook(radius: float, min_points: int) -> None:
    for seed in range(3):
        spread = int(4 + 2 * radius)
        cells, member_set, member_cell = random_sets(seed, 300, 3, spread)
        labels = cluster(cells, member_set, member_cell, radius, min_points)
        for number in range(3):
            mine = member_set == number
            check_against_slow(cells.coordinates[member_cell[mine]], labels[mine], radius, min_points)


def test_labels_are_never_shared_between_sets() -> None:
    cells, member_set, member_cell = random_sets(7, 400, 4, 6)
    labels = cluster(cells, member_set, member_cell, 2.0, 4)
    found = {(s, label) for s, label in zip(member_set, labels, strict=True) if label >= 0}
    assert len(found) > 4
    assert len({label for _, label in found}) == len(found)


def lines(*rows: range) -> tuple:
    """Cells along x at y = 0, one range for each set, as cells and members."""
    cells = cells_at([[x, 0, 0] for x in sorted({x for row in rows for x in row})])
    pairs = [(c, s) for c, (x, _, _) in enumerate(cells.coordinates) for s, row in enumerate(rows) if x in row]
    member_cell, member_set = np.array(pairs, np.int32).T
    return cells, member_set, member_cell


def test_a_line_across_block_borders_is_one_cluster() -> None:
    cells, member_set, member_cell = lines(range(-40, 41))
    assert len(cells.block_keys) == 6
    labels = cluster(cells, member_set, member_cell, 1.0, 3)
    assert len(set(labels)) == 1
    assert labels[0] >= 0  # the ends are border points


def test_a_gap_wider_than_the_radius_splits() -> None:
    cells, member_set, member_cell = lines([*range(-5, 0), *range(2, 8)])  # type: ignore[arg-type]
    for radius, clusters in ((2.0, 2), (3.0, 1)):
        labels = cluster(cells, member_set, member_cell, radius, 2)
        assert len(set(labels)) == clusters


def test_overlapping_sets_are_clustered_apart() -> None:
    # Set 0 is broken where set 1 is whole: cells they share do not bridge set 0.
    cells, member_set, member_cell = lines([*range(4), *range(8, 12)], range(12))  # type: ignore[arg-type]
    labels = cluster(cells, member_set, member_cell, 1.0, 2)
    assert len(set(labels[member_set == 0])) == 2
    assert len(set(labels[member_set == 1])) == 1


def test_border_point_between_two_clusters_goes_to_the_core_that_comes_first() -> None:
    # Two dense ends, and between them one cell that is no core; the left end's cells come first in the order.
    ends = [(x, y, 8) for x in (1, 2, 4, 5) for y in (6, 7, 8)]
    cells = cells_at([*ends, (3, 7, 8)])
    everything = np.arange(len(cells), dtype=np.int32)
    labels = cluster(cells, np.zeros_like(everything), everything, 1.0, 4)
    label_at = dict(zip(map(tuple, cells.coordinates.tolist()), labels.tolist(), strict=True))
    assert -1 < label_at[2, 7, 8] != label_at[4, 7, 8] > -1
    assert label_at[3, 7, 8] == label_at[2, 7, 8]


def test_noise_is_minus_one() -> None:
    cells = cells_at([(0, 0, 0), (1, 0, 0), (0, 1, 0), (9, 9, 9)])
    everything = np.arange(4, dtype=np.int32)
    labels = cluster(cells, np.zeros(4, np.int32), everything, 1.0, 3)
    lone = int(np.flatnonzero((cells.coordinates == 9).all(axis=1))[0])
    assert labels[lone] == -1
    assert (np.delete(labels, lone) == labels[1 - min(lone, 1)]).all()


def test_renumbering_the_sets_changes_no_cluster() -> None:
    cells, member_set, member_cell = random_sets(11, 300, 3, 7)
    labels = cluster(cells, member_set, member_cell, 2.0, 5)
    renamed = np.array([2, 0, 1], np.int32)[member_set]
    order = np.lexsort((renamed, member_cell))
    other = np.empty_like(labels)
    other[order] = cluster(cells, renamed[order], member_cell[order], 2.0, 5)
    assert np.array_equal(labels < 0, other < 0)
    pairs = set(zip(labels, other, strict=True))
    assert len(pairs) == len(set(labels)) == len(set(other))


def test_no_members_give_no_labels() -> None:
    nothing = np.zeros(0, np.int32)
    assert len(cluster(cells_at([(0, 0, 0)]), nothing, nothing, 2.0, 3)) == 0


@pytest.mark.parametrize("radius", [1.0, 2.5, 4.0])
def test_neighbour_pairs_are_all_pairs_within_the_radius_once(radius: float) -> None:
    cells, _, _ = random_sets(3, 250, 1, 9)
    gap = ((cells.coordinates[:, None] - cells.coordinates[None]) ** 2).sum(axis=2)
    expected = {(int(a), int(b)) for a, b in np.argwhere(gap <= radius**2 + 1e-9) if a < b}
    everything = np.arange(len(cells), dtype=np.int32)
    near, far = _neighbours(cells, np.zeros_like(everything), everything, radius)
    first, second = (np.concatenate([a, b]) for a, b in zip(near, far, strict=True))
    found = [(min(a, b), max(a, b)) for a, b in zip(first.tolist(), second.tolist(), strict=True)]
    assert len(found) == len(set(found))
    assert set(found) == expected
