"""What predictions lie on: the truth under each predicted instance's own surface."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from razer.arrays import Int64Array
from razer.metrics.instances.prediction_account import Ground, count_grounds
from razer.metrics.preset import Preset
from razer.metrics.protocol.scene_labels import SceneLabels
from razer.metrics.scene_pair import PredictedScene, TruthScene
from razer.metrics.surface.nearest_vertices import nearest_vertices
from razer.metrics.surface.surface_errors import SurfaceDistances


def prediction_grounds(
    truth: TruthScene,
    predicted: PredictedScene,
    labels: SceneLabels,
    distances: SurfaceDistances | None,
    evaluated: Collection[int],
    preset: Preset,
) -> dict[int, Int64Array]:
    """Vertices of each predicted instance on each `Ground`: id -> (4,).

    A surface of its own is judged by its own vertices, so that what hangs in the air counts, too: a vertex farther from
    the truth than instances reach lies on nothing, any other on what the nearest true vertex is. Arguments: both sides
    as they are and on the evaluated vertices, their distances, the numbers of evaluated classes, and the rules."""
    ground = _ground_of_truth(labels, evaluated, preset)
    if predicted.vertices is None or predicted.instances is None or distances is None:
        return _on_truth(labels, ground)
    everywhere = np.full(len(truth.vertices), Ground.UNCOUNTED, np.int64)
    everywhere[truth.counts] = ground
    of_instance = np.flatnonzero(predicted.instances > 0)
    limit = np.inf if preset.instance_max_m is None else preset.instance_max_m
    below = np.full(len(of_instance), Ground.NOTHING, np.int64)
    is_near = distances.to_truth[of_instance] <= limit
    nearest = nearest_vertices(truth.vertices, predicted.vertices[of_instance[is_near]])
    below[is_near] = everywhere[nearest.index[:, 0]]
    return count_grounds(np.asarray(predicted.instances, np.int64)[of_instance], below)


def _ground_of_truth(labels: SceneLabels, evaluated: Collection[int], preset: Preset) -> Int64Array:
    """What each evaluated vertex (V,) is."""
    instances, classes = labels.truth_instances, labels.truth_classes
    stuff = labels.table.subset((*preset.stuff, *preset.instance_ignored))
    kinds = labels.truth_instance_classes
    # A truth without any class has things alone.
    things = [i for i, c in kinds.items() if c in evaluated] if kinds else np.unique(instances)
    stuff_instances = [i for i, c in kinds.items() if c in stuff]
    is_stuff = np.where(instances > 0, np.isin(instances, stuff_instances), classes > 0)
    ground = np.where(instances > 0, Ground.UNCOUNTED, Ground.NOTHING)
    ground = np.where(is_stuff, Ground.STUFF, ground)
    return np.where((instances > 0) & np.isin(instances, things), Ground.THING, ground).astype(np.int64)


def _on_truth(labels: SceneLabels, ground: Int64Array) -> dict[int, Int64Array]:
    """Of labels or masks on the truth's own vertices."""
    instances = labels.predicted_instances
    if instances is None:
        return {}
    if isinstance(instances, Mapping):
        return {i: np.bincount(ground[mask], minlength=len(Ground)) for i, mask in instances.items()}
    return count_grounds(instances, ground)
