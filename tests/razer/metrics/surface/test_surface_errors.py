"""Distances between surfaces against every triangle by brute force, and cases with known answers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from razer.metrics.scene_pair import PredictedScene, TruthScene
from razer.metrics.surface.point_triangle import squared_distances
from razer.metrics.surface.surface_distance import TriangleSurface
from razer.metrics.surface.surface_errors import metrics_of_distances, surface_metrics


def slow_distance(point: np.ndarray, corners: np.ndarray) -> float:
    """By minimising over the triangle with ever finer grids of barycentric coordinates round the best one."""
    low, high = np.zeros(2), np.ones(2)
    for _ in range(25):
        v, w = (g.ravel() for g in np.meshgrid(*[np.linspace(low[i], high[i], 11) for i in (0, 1)]))
        inside = (v >= 0) & (w >= 0) & (v + w <= 1 + 1e-15)
        v, w = v[inside], w[inside]
        at = corners[0] + v[:, None] * (corners[1] - corners[0]) + w[:, None] * (corners[2] - corners[0])
        lengths = np.linalg.norm(at - point, axis=1)
        best = int(lengths.argmin())
        half = (high - low) / 4
        low = np.maximum(np.array([v[best], w[best]]) - half, 0)
        high = np.minimum(np.array([v[best], w[best]]) + half, 1)
    return float(lengths[best])


def wavy_sheet(n: int, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    x, y = np.meshgrid(np.arange(n) * spacing, np.arange(n) * spacing, indexing="ij")
    vertices = np.stack([x, y, 0.1 * np.sin(4 * x) * np.cos(3 * y)], axis=-1).reshape(-1, 3)
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, 1:].ravel()
    return vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)])


def truth_of(vertices: np.ndarray, triangles: np.ndarray | None, evaluated: np.ndarray | None = None) -> TruthScene:
    nothing = np.zeros(len(vertices), int)
    return TruthScene(vertices, nothing, nothing, {}, triangles, evaluated)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 100_000), st.sampled_from(["any", "needle", "point"]))
def test_distance_from_a_triangle(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    corners, point = rng.normal(size=(3, 3)), 1.5 * rng.normal(size=3)
    if kind == "needle":
        corners[2] = corners[0] + 0.3 * (corners[1] - corners[0])
    if kind == "point":
        corners[:] = corners[0]
    distances = np.sqrt(squared_distances(point[:, None], corners[:, :, None]))[0]
    assert distances == pytest.approx(slow_distance(point, corners), abs=1e-5)


def test_distances_are_those_of_the_nearest_of_all_triangles() -> None:
    vertices, triangles = wavy_sheet(12, 0.03)
    points = vertices[np.random.default_rng(1).integers(0, len(vertices), 200)]
    points = points + np.random.default_rng(2).normal(0, 0.02, points.shape)
    corners = vertices[triangles].transpose(1, 2, 0)
    expected = [np.sqrt(squared_distances(p[:, None], corners).min()) for p in points]
    assert TriangleSurface(vertices, triangles).distances(points) == pytest.approx(expected, abs=1e-12)


def test_vertex_spacing_does_not_matter() -> None:
    # Two triangles of ten metres; nearest vertices would be metres away.
    wall = np.array([[0.0, 0, 0], [10, 0, 0], [10, 0, 3], [0, 0, 3]])
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    points = np.random.default_rng(0).random((500, 3)) * [10, 0, 3] + [0, 0.03, 0]
    assert TriangleSurface(wall, triangles).distances(points) == pytest.approx(0.03, abs=1e-12)
    # A second wall behind the points is nearer than the first.
    both = np.concatenate([wall, wall + np.array([0, 0.05, 0])])
    distances = TriangleSurface(both, np.concatenate([triangles, triangles + 4])).distances(points)
    assert distances == pytest.approx(0.02, abs=1e-12)


def test_a_fine_mesh_does_not_hide_the_large_triangles_beside_it() -> None:
    sheet, sheet_triangles = wavy_sheet(20, 0.02)
    wall = np.array([[-5.0, -5, -0.3], [5, -5, -0.3], [5, 5, -0.3], [-5, 5, -0.3]])
    triangles = np.concatenate([sheet_triangles, np.array([[0, 1, 2], [0, 2, 3]]) + len(sheet)])
    points = np.random.default_rng(0).random((200, 3)) * [0.3, 0.3, 0] + [0.04, 0.04, -0.27]
    # The wall is 3 cm away; its corners are metres away, the vertices of the sheet 17 to 37 cm.
    assert TriangleSurface(np.concatenate([sheet, wall]), triangles).distances(points) == pytest.approx(0.03, abs=1e-12)


def test_truth_against_itself_is_exactly_perfect() -> None:
    vertices, triangles = wavy_sheet(15, 0.04)
    numbers = surface_metrics(truth_of(vertices, triangles), PredictedScene(vertices, triangles=triangles))
    assert numbers is not None
    assert (numbers.accuracy_m, numbers.completeness_m, numbers.chamfer_m) == (0.0, 0.0, 0.0)
    assert set(numbers.fscore.values()) == {1.0}


def test_lengths_and_shares() -> None:
    numbers = metrics_of_distances(np.array([0.0, 0.02, 0.05, 0.13]), np.array([0.01, 0.06]))
    assert numbers.accuracy_m == pytest.approx(0.05)
    assert numbers.completeness_m == pytest.approx(0.035)
    assert numbers.chamfer_m == pytest.approx(0.0425)
    assert (numbers.precision[0.02], numbers.recall[0.02]) == (0.5, 0.5)
    assert numbers.fscore[0.05] == pytest.approx(2 * 0.75 * 0.5 / 1.25)
    assert metrics_of_distances(np.ones(2), np.ones(2)).fscore[0.02] == 0.0


def test_unobserved_truth_need_not_be_complete_but_may_be_hit() -> None:
    vertices, triangles = wavy_sheet(10, 0.05)
    seen = vertices[:, 0] < 0.2
    half = PredictedScene(vertices[seen])
    blamed = surface_metrics(truth_of(vertices, triangles), half)
    fair = surface_metrics(truth_of(vertices, triangles, seen), half)
    assert blamed is not None
    assert fair is not None
    assert blamed.completeness_m > 0.05
    assert fair.completeness_m == 0.0
    # All of the surface predicted, though only half was to be seen: nothing is wrong with it.
    whole = surface_metrics(truth_of(vertices, triangles, seen), PredictedScene(vertices, triangles=triangles))
    assert whole is not None
    assert whole.accuracy_m == 0.0


def test_a_shift_is_measured_as_it_is() -> None:
    flat = np.stack(np.meshgrid(np.arange(30) * 0.02, np.arange(30) * 0.02, [0.0]), -1).reshape(-1, 3)
    _, triangles = wavy_sheet(30, 0.02)
    lifted = PredictedScene(flat + np.array([0, 0, 0.03]), triangles=triangles)
    numbers = surface_metrics(truth_of(flat, triangles), lifted)
    assert numbers is not None
    assert numbers.accuracy_m == pytest.approx(0.03, abs=1e-12)
    assert numbers.completeness_m == pytest.approx(0.03, abs=1e-12)
    assert (numbers.fscore[0.02], numbers.fscore[0.05]) == (0.0, 1.0)


def test_sides_without_a_surface() -> None:
    vertices, triangles = wavy_sheet(4, 0.05)
    truth = truth_of(vertices, triangles)
    assert surface_metrics(truth, PredictedScene(masks={1: np.arange(3)})) is None
    assert surface_metrics(truth, PredictedScene(np.zeros((0, 3)))) is None
    assert surface_metrics(truth_of(vertices, triangles, np.zeros(16, bool)), PredictedScene(vertices)) is None
    on_truth = surface_metrics(truth, PredictedScene(instances=np.ones(16, int)))
    assert on_truth is not None
    assert on_truth.on_truth
    assert on_truth.accuracy_m == 0.0
    assert np.isinf(TriangleSurface(np.zeros((0, 3))).distances(vertices)).all()
