"""Surface reconstruction metrics: accuracy, completeness, chamfer distance, F-score."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from razer.arrays import FloatArray
from razer.metrics.scene_pair import PredictedScene, TruthScene
from razer.metrics.surface.surface_distance import TriangleSurface

F_SCORE_LIMITS_M = (0.02, 0.05)


@dataclass(frozen=True, slots=True)
class SurfaceMetrics:
    """accuracy_m: mean distance of the predicted vertices from the true surface; completeness_m: of the true ones that
    count from the predicted surface; chamfer_m: the mean of both. By limit in metres: precision and recall, the shares
    within it of predicted and true vertices, and fscore, their harmonic mean. on_truth: whether the prediction lies on
    the truth's own vertices, so that the distances are 0 and do not measure the system."""

    accuracy_m: float
    completeness_m: float
    chamfer_m: float
    precision: Mapping[float, float]
    recall: Mapping[float, float]
    fscore: Mapping[float, float]
    on_truth: bool = False


@dataclass(frozen=True, slots=True)
class SurfaceDistances:
    """Metres: to_truth (P,) of the predicted vertices from the true surface, to_predicted (C,) of the true ones that
    count from the predicted surface."""

    to_truth: FloatArray
    to_predicted: FloatArray


def surface_distances(truth: TruthScene, predicted: PredictedScene) -> SurfaceDistances | None:
    """The distances between both surfaces; None where the prediction has none of its own, or either side no vertex."""
    if predicted.vertices is None or len(predicted.vertices) == 0 or not truth.counts.any():
        return None
    return SurfaceDistances(
        TriangleSurface(truth.vertices, truth.triangles).distances(predicted.vertices),
        TriangleSurface(predicted.vertices, predicted.triangles).distances(truth.vertices[truth.counts]),
    )


def surface_metrics(
    truth: TruthScene, predicted: PredictedScene, distances: SurfaceDistances | None = None
) -> SurfaceMetrics | None:
    """Compare the surfaces, by their distances if these are known; None where the prediction is masks only, or either
    side has no vertex.

    Vertices that no frame observed need not be complete, but a prediction may lie on them. Labels on the truth's
    vertices have the truth's surface, which is 0 from itself."""
    distances = distances or surface_distances(truth, predicted)
    if distances is not None:
        return metrics_of_distances(distances.to_truth, distances.to_predicted)
    is_labelled = predicted.instances is not None or predicted.classes is not None
    if predicted.vertices is not None or not is_labelled or not truth.counts.any():
        return None
    zeros = np.zeros(len(truth.vertices))
    return replace(metrics_of_distances(zeros, zeros), on_truth=True)


def metrics_of_distances(to_truth_m: FloatArray, to_predicted_m: FloatArray) -> SurfaceMetrics:
    """The metrics of the distances (P,) of predicted and (V,) of true vertices, metres, at least one of each."""
    accuracy, completeness = float(to_truth_m.mean()), float(to_predicted_m.mean())
    precision = {limit: float((to_truth_m <= limit).mean()) for limit in F_SCORE_LIMITS_M}
    recall = {limit: float((to_predicted_m <= limit).mean()) for limit in F_SCORE_LIMITS_M}
    fscore = {limit: _harmonic(precision[limit], recall[limit]) for limit in F_SCORE_LIMITS_M}
    return SurfaceMetrics(accuracy, completeness, (accuracy + completeness) / 2, precision, recall, fscore)


def _harmonic(a: float, b: float) -> float:
    return 2 * a * b / (a + b) if a + b > 0 else 0.0
