"""Transfer of a prediction's instances and classes to the vertices of the truth."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from razer.arrays import BoolArray, Int64Array, IntArray
from razer.metrics.preset import Preset
from razer.metrics.protocol.vertex_masks import VertexMasks
from razer.metrics.scene_pair import PredictedScene, TruthScene
from razer.metrics.surface.nearest_vertices import Neighbours, nearest_vertices

InstanceLabels = Int64Array | VertexMasks
"""Instance ids (V,), or masks where instances may overlap."""


class LabelTransfer:
    """Predicted labels on the truth's V vertices, by a preset's rules.

    A prediction on the truth's own vertices stays as it is where one neighbour decides; where a majority does, it is
    taken as a surface with the truth's vertices."""

    def __init__(self, truth: TruthScene, predicted: PredictedScene, preset: Preset) -> None:
        self._truth = truth
        self._predicted = predicted
        self._preset = preset
        self._source = truth.vertices if predicted.vertices is None else predicted.vertices
        self._neighbours: dict[tuple[int, float | None], Neighbours] = {}

    def instances(self) -> InstanceLabels | None:
        """The predicted instances, None where there are none. Raises ValueError for labels that do not fit."""
        n_vertices = len(self._truth.vertices)
        if self._predicted.masks is not None:
            return VertexMasks(self._predicted.masks, n_vertices)
        if self._predicted.instances is None:
            return None
        return self._transferred(self._predicted.instances, self._preset.instance_k, self._preset.instance_max_m)

    def classes(
        self, vertex_classes: Mapping[int, int], instance_classes: Mapping[int, int], instances: InstanceLabels | None
    ) -> Int64Array | None:
        """The predicted classes (V,), None where there are none: those of the vertices, else those of the instances as
        predicted, else those of the transferred masks. The mappings give the class of each label."""
        predicted, preset = self._predicted, self._preset
        if predicted.classes is not None:
            labels = relabel(predicted.classes, vertex_classes)
        elif predicted.instances is not None and predicted.class_names:
            labels = relabel(predicted.instances, instance_classes)
        elif isinstance(instances, Mapping) and predicted.class_names:
            labels = relabel(flatten_masks(instances, predicted.scores, len(self._truth.vertices)), instance_classes)
        else:
            return None
        voters = None if preset.unlabelled_vote else labels > 0
        return self._transferred(labels, preset.semantic_k, preset.semantic_max_m, voters)

    def _transferred(
        self, labels: IntArray, k: int, max_m: float | None, voters: BoolArray | None = None
    ) -> Int64Array:
        _check_length(labels, len(self._source))
        if self._predicted.vertices is None and k == 1:
            return np.asarray(labels, np.int64)
        if voters is not None:
            return nearest_vertices(self._source, self._truth.vertices, k, max_m, voters).labels(labels)
        if (k, max_m) not in self._neighbours:
            self._neighbours[k, max_m] = nearest_vertices(self._source, self._truth.vertices, k, max_m)
        return self._neighbours[k, max_m].labels(labels)


def relabel(labels: IntArray, numbers: Mapping[int, int]) -> Int64Array:
    """Each label (V,) replaced by its number, 0 where it has none."""
    distinct, index = np.unique(labels, return_inverse=True)
    return np.array([numbers.get(int(label), 0) for label in distinct], np.int64)[index].reshape(len(labels))


def flatten_masks(masks: Mapping[int, Int64Array], scores: Mapping[int, float], n_vertices: int) -> Int64Array:
    """One id for each of V vertices: of the masks over it the one with the highest score, then the lowest id."""
    ids = np.zeros(n_vertices, np.int64)
    for number in sorted(masks, key=lambda i: (scores.get(i, 1.0), -i)):
        ids[masks[number]] = number
    return ids


def _check_length(labels: IntArray, n_vertices: int) -> None:
    if len(labels) != n_vertices:
        raise ValueError(f"{len(labels)} predicted labels for {n_vertices} true vertices: one of each is needed")
