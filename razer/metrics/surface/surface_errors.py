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


def surface_metrics(truth: TruthScene, predicted: PredictedScene) -> SurfaceMetrics | None:
    """Compare the surfaces; None where the prediction is masks only, or where either side has no vertex.

    Vertices that no frame observed need not be complete, but a prediction may lie on them. Labels on the truth's
    vertices have the truth's surface, which is 0 from itself."""
    if not truth.counts.any():
        return None
    if predicted.vertices is None:
        zeros = np.zeros(len(truth.vertices))
        is_labelled = predicted.instances is not None or predicted.classes is not None
        return replace(metrics_of_distances(zeros, zeros), on_truth=True) if is_labelled else None
    if len(predicted.vertices) == 0:
        return None
    to_truth = TriangleSurface(truth.vertices, truth.triangles).distances(predicted.vertices)
    to_prediction = TriangleSurface(predicted.vertices, predicted.triangles).distances(truth.vertices[truth.counts])
    return metrics_of_distances(to_truth, to_prediction)


def metrics_of_distances(to_truth_m: FloatArray, to_predicted_m: FloatArray) -> SurfaceMetrics:
    """The metrics of the distances (P,) of predicted and (V,) of true vertices, metres, at least one of each."""
    accuracy, completeness = float(to_truth_m.mean()), float(to_predicted_m.mean())
    precision = {limit: float((to_truth_m <= limit).mean()) for limit in F_SCORE_LIMITS_M}
    recall = {limit: float((to_predicted_m <= limit).mean()) for limit in F_SCORE_LIMITS_M}
    fscore = {limit: _harmonic(precision[limit], recall[limit]) for limit in F_SCORE_LIMITS_M}
    return SurfaceMetrics(accuracy, completeness, (accuracy + completeness) / 2, precision, recall, fscore)


def _harmonic(a: float, b: float) -> float:
    return 2 * a * b / (a + b) if a + b > 0 else 0.0
