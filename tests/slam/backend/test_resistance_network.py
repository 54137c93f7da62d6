"""Variance between keyframes: ways in series and side by side, against the whole network solved at once."""

from __future__ import annotations

import numpy as np
import pytest

from slam.backend import resistance_network as module
from slam.backend.resistance_network import ResistanceNetwork


def network_of(edges):
    network = ResistanceNetwork()
    for a, b, variance in edges:
        network.add(a, b, variance)
    return network


def slow_variances(edges, start):
    """By the pseudoinverse of the whole Laplacian."""
    numbers = sorted({n for a, b, _ in edges for n in (a, b)})
    row = {number: n for n, number in enumerate(numbers)}
    laplacian = np.zeros((len(numbers), len(numbers)))
    for a, b, variance in edges:
        for one, other in ((row[a], row[b]), (row[b], row[a])):
            laplacian[one, one] += 1 / variance
            laplacian[one, other] -= 1 / variance
    inverse, s = np.linalg.pinv(laplacian), row[start]
    return {n: inverse[row[n], row[n]] + inverse[s, s] - 2 * inverse[s, row[n]] for n in numbers}


def random_edges(rng, n, more):
    chain = [(i, i + 1) for i in range(n - 1)]
    pairs = chain + [tuple(sorted(rng.choice(n, 2, replace=False).tolist())) for _ in range(more)]
    return [(a, b, float(rng.uniform(0.2, 3.0))) for a, b in pairs]


def test_variances_add_up_along_a_way_and_ways_side_by_side_share_them():
    network = network_of([(0, 1, 2.0), (1, 2, 3.0), (0, 2, 5.0), (2, 3, 1.0), (2, 3, 1.0)])
    assert network.variances_from(0) == pytest.approx({0: 0, 1: 1.6, 2: 2.5, 3: 3.0})  # 2 | 8, 5 | 5, and 1 | 1 more
    assert network.usual_variance == 2.0
    assert network.joined(2, 0)
    assert not network.joined(0, 3)
    assert network.variances_from(9) == {9: 0.0}


@pytest.mark.parametrize("seed", range(3))
def test_variances_are_those_of_the_whole_network(seed):
    edges = random_edges(np.random.default_rng(seed), 40, 50)
    for start in (0, 17):
        assert network_of(edges).variances_from(start) == pytest.approx(slow_variances(edges, start))


def test_of_many_keyframes_the_nearest_are_told_and_never_too_sure(monkeypatch):
    monkeypatch.setattr(module, "NEAREST", 20)
    edges = random_edges(np.random.default_rng(0), 200, 60)
    told, whole = network_of(edges).variances_from(100), slow_variances(edges, 100)
    assert len(told) == 20
    assert all(variance >= whole[number] - 1e-9 for number, variance in told.items())
    assert {99, 101} <= set(told)
