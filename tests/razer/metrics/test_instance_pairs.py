"""Instances of two maps in pairs, against a slow reference that follows the definition."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from razer.metrics.instances.instance_pairs import pair_instances


def slow_pairs(vertices_a, ids_a, vertices_b, ids_b, min_iou):
    """By the definition: labels carried one vertex at a time, every assignment tried."""

    def carried(vertices, others, ids):
        result = []
        for vertex in vertices:
            distances = [np.linalg.norm(vertex - other) for other in others]
            nearest = int(np.argmin(distances))
            result.append(ids[nearest] if distances[nearest] <= 0.05 else 0)
        return result

    bearing = list(zip(ids_a, carried(vertices_a, vertices_b, ids_b), strict=True))
    bearing += list(zip(carried(vertices_b, vertices_a, ids_a), ids_b, strict=True))

    def iou(a, b):
        both = sum(x == a and y == b for x, y in bearing)
        return both / sum(x == a or y == b for x, y in bearing)

    known_a, known_b = sorted(set(ids_a) - {0}), sorted(set(ids_b) - {0})
    padded = known_b + [0] * len(known_a)
    best, pairs = -1.0, []
    for chosen in permutations(padded, len(known_a)):
        found = [(a, b, iou(a, b)) for a, b in zip(known_a, chosen, strict=True) if b and iou(a, b) >= min_iou]
        if sum(one[2] for one in found) > best + 1e-12:
            best, pairs = sum(one[2] for one in found), found
    return pairs


@pytest.mark.parametrize("seed", range(4))
def test_pairs_are_those_of_the_definition(seed):
    rng = np.random.default_rng(seed)
    vertices_a = rng.uniform(0, 0.3, (40, 3))
    ids_a = (vertices_a[:, 0] // 0.1).astype(np.int64)
    vertices_b = np.concatenate([vertices_a[:30] + rng.normal(scale=0.02, size=(30, 3)), rng.uniform(0, 0.3, (9, 3))])
    ids_b = 5 + (vertices_b[:, 0] // 0.08).astype(np.int64).clip(0, 2)
    found = pair_instances(vertices_a, ids_a, vertices_b, ids_b, min_iou=0.1)
    expected = slow_pairs(vertices_a, ids_a.tolist(), vertices_b, ids_b.tolist(), 0.1)
    assert found
    assert [(pair.a, pair.b, pytest.approx(pair.iou)) for pair in found] == expected
    # Neither map is the measure of the other.
    back = pair_instances(vertices_b, ids_b, vertices_a, ids_a, min_iou=0.1)
    assert sorted((pair.b, pair.a, pair.iou) for pair in back) == sorted(found)


def test_of_rivals_the_pairs_that_overlap_most_together_win():
    # 1 overlaps both 5 and 6, 2 only 5: leaving 5 to 2 gives two pairs.
    points = np.arange(40)[:, None] * np.ones(3)
    ids_a = np.repeat([1, 2], [24, 16])
    ids_b = np.repeat([6, 5], [10, 30])
    pairs = pair_instances(points, ids_a, points, ids_b)
    assert [(pair.a, pair.b) for pair in pairs] == [(1, 6), (2, 5)]
    nobody = np.zeros(40, np.int64)
    assert pair_instances(points, ids_a, points, nobody) == ()
