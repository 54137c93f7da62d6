"""Local planes and region graphs against slow, obvious references."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from razer.models.geometric.local_planes import fit_local_planes, inverse_depth
from razer.models.geometric.region_graph import RegionGraph
from razer.models.geometric.region_planes import plane_misfit, plane_sums
from razer.models.geometric.surface_edges import normals
from tests.support.depth_scenes import CAMERA, plane

NOISE_PER_M = 0.0016


def test_a_plane_with_holes_is_recovered_everywhere() -> None:
    normal = np.array((0.48, -0.36, 0.8))
    depth = plane(tuple(normal), 1.5).astype(np.float32)
    depth[np.random.default_rng(0).random(depth.shape) < 0.3] = 0
    inverse = inverse_depth(depth, 1, NOISE_PER_M)
    planes = fit_local_planes(inverse, NOISE_PER_M)
    np.testing.assert_array_equal(planes.valid, depth > 0)
    np.testing.assert_allclose(planes.value[planes.valid], inverse[planes.valid], atol=2e-5)
    directions = normals(planes, CAMERA)[:, planes.valid]
    assert np.degrees(np.arccos(np.clip(normal @ directions, -1, 1))).max() < 1


def test_planes_up_to_a_step_are_those_of_their_own_side() -> None:
    near, far = plane((0.3, 0, 1), 1.0), plane((-0.3, 0.2, 1), 2.0)
    left = np.arange(640)[None] < 321
    inverse = inverse_depth(np.where(left, near, far).astype(np.float32), 1, NOISE_PER_M)
    planes = fit_local_planes(inverse, NOISE_PER_M)
    for surface, columns in ((near, slice(0, 321)), (far, slice(321, 640))):
        expected = np.gradient(1 / surface, axis=1)[:, columns]
        np.testing.assert_allclose(planes.slope_x[:, columns], expected, atol=1e-5)


def test_a_block_on_a_step_takes_its_nearest_surface() -> None:
    depth = np.array([[1.0, 1.001, 0, 0], [2.0, 0, 0, 3.0]], np.float32)
    np.testing.assert_allclose(inverse_depth(depth, 2, NOISE_PER_M), [[(1 + 1 / 1.001) / 2, 1 / 3]], rtol=1e-6)


def graph_of(labels: np.ndarray, seed: int = 0) -> RegionGraph:
    rng = np.random.default_rng(seed)
    pixels = np.stack([np.ones(labels.shape), rng.random(labels.shape)]).astype(np.float32)
    sides = [np.stack([np.ones(labels.shape), rng.random(labels.shape)]).astype(np.float32) for _ in range(2)]
    return RegionGraph.of(labels.astype(np.int32), labels.max() + 1, pixels, (sides[0], sides[1]), 1)


label_images = st.integers(0, 2**31).map(lambda seed: np.random.default_rng(seed).integers(-1, 6, (7, 9)))


@given(label_images)
def test_sums_and_borders_equal_those_of_a_loop(labels: np.ndarray) -> None:
    labels[0, 0] = 5  # so that all six are there to count
    graph, lengths = graph_of(labels), {}
    for y, x in np.ndindex(labels.shape):
        for other in ((y, x + 1), (y + 1, x)):
            if other[0] < labels.shape[0] and other[1] < labels.shape[1]:
                pair = tuple(sorted((int(labels[y, x]), int(labels[other]))))
                if pair[0] >= 0 and pair[0] != pair[1]:
                    lengths[pair] = lengths.get(pair, 0) + 1
    assert {
        tuple(pair): length for pair, length in zip(graph.pairs.tolist(), graph.boundary[:, 0], strict=True)
    } == lengths
    assert graph.sums[:, 0].tolist() == [int((labels == i).sum()) for i in range(6)]


@settings(deadline=None)
@given(label_images, st.integers(0, 2**31))
def test_merging_all_cheap_pairs_leaves_their_connected_components(labels: np.ndarray, seed: int) -> None:
    labels[0, 0] = 5
    graph = graph_of(labels, seed)
    cheap = np.random.default_rng(seed).random((6, 6)) < 0.4  # fixed by the first regions: merging changes nothing
    cheap = cheap | cheap.T
    first = graph.pairs

    def cost(now: RegionGraph) -> np.ndarray:
        joined = np.zeros((6, 6), bool)
        ends = now.region[first[cheap[first[:, 0], first[:, 1]]]]
        joined[ends[:, 0], ends[:, 1]] = joined[ends[:, 1], ends[:, 0]] = True
        return np.where(joined[now.pairs[:, 0], now.pairs[:, 1]], 0.5, 2.0)

    merged = graph.merged(cost)
    links = first[cheap[first[:, 0], first[:, 1]]]
    expected = connected_components(coo_matrix((np.ones(len(links)), links.T), shape=(6, 6)), directed=False)[1]
    same = merged.region[:, None] == merged.region[None]
    np.testing.assert_array_equal(same, expected[:, None] == expected[None])
    np.testing.assert_allclose(merged.sums.sum(axis=0), graph.sums.sum(axis=0))
    apart = merged.region[first[:, 0]] != merged.region[first[:, 1]]
    np.testing.assert_allclose(merged.boundary.sum(axis=0), graph.boundary[apart].sum(axis=0))


def test_the_cheapest_pair_merges_first_and_costs_are_asked_afresh() -> None:
    labels = np.array([[0, 0, 0, 1, 1, 2]])
    means = {0: 0.0, 1: 1.0, 2: 1.5}
    pixels = np.stack([np.ones(labels.shape), np.vectorize(means.get)(labels)]).astype(np.float32)
    side = np.ones((1, *labels.shape), np.float32)
    graph = RegionGraph.of(labels.astype(np.int32), 3, pixels, (side, side), 1)

    def difference_of_means(now: RegionGraph) -> np.ndarray:
        mean = now.sums[:, 1] / np.maximum(now.sums[:, 0], 1)
        return np.abs(mean[now.pairs[:, 0]] - mean[now.pairs[:, 1]])

    # 1 and 2 merge first, as they differ least; together they differ by 1.17 from 0, which stays alone.
    assert graph.merged(difference_of_means).region.tolist() == [0, 1, 1]


def test_plane_misfit_equals_a_fit_by_least_squares() -> None:
    rng = np.random.default_rng(4)
    u, v = (rng.uniform(-0.5, 0.5, (2, 40, 50))).astype(np.float32)
    inverse = (0.4 + 0.2 * u - 0.1 * v + rng.normal(0, 0.01, u.shape)).astype(np.float32)
    large = np.arange(50)[None] < 35
    inverse = np.where(large, inverse, inverse + np.float32(0.05))
    products = plane_sums(inverse, u, v)
    sums = np.stack([products[:, np.broadcast_to(part, u.shape)].sum(axis=1) for part in (large, ~large)]).astype(float)
    inside = np.broadcast_to(large, u.shape)
    columns = np.stack([np.ones_like(u), u, v], axis=-1)
    solution = np.linalg.lstsq(columns[inside], inverse[inside], rcond=None)[0]
    expected = np.sqrt(np.mean((columns[~inside] @ solution - inverse[~inside]) ** 2))
    assert plane_misfit(sums, np.array([[0, 1]]))[0] == pytest.approx(expected, rel=1e-3)


def test_a_line_of_pixels_has_no_plane() -> None:
    u = np.linspace(-0.5, 0.5, 20, dtype=np.float32)[None]
    products = plane_sums(u * 0 + 0.5, u, u * 0)
    sums = np.stack([products.sum(axis=(1, 2)), products[:, :, :5].sum(axis=(1, 2))]).astype(float)
    assert np.isinf(plane_misfit(sums, np.array([[0, 1]])))
