"""Labels of truth and prediction on the truth's evaluated vertices, by a preset's rules."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from razer.arrays import BoolArray, Int64Array
from razer.metrics.class_table import ClassTable
from razer.metrics.preset import Preset
from razer.metrics.protocol.vertex_labels import InstanceLabels, LabelTransfer, flatten_masks, relabel
from razer.metrics.scene_pair import PredictedScene, TruthScene


@dataclass(frozen=True, slots=True)
class SceneLabels:
    """V evaluated vertices. truth_instances, truth_classes (V,); predicted_instances as ids or masks, None where the
    prediction has none; predicted_classes (V,), None where it names none; classes are numbers of the table, 0 for none.
    The classes of true and predicted instances are given by id, the unknown ones left out. scores, and
    name_probabilities where they are known, by predicted id."""

    table: ClassTable
    truth_instances: Int64Array
    truth_classes: Int64Array
    truth_instance_classes: Mapping[int, int]
    predicted_instances: InstanceLabels | None
    predicted_classes: Int64Array | None
    predicted_instance_classes: Mapping[int, int]
    scores: Mapping[int, float]
    name_probabilities: Mapping[int, float]

    @property
    def single_instances(self) -> Int64Array:
        """One predicted instance for each vertex (V,): where masks overlap that of the higher score, then lower id."""
        instances = self.predicted_instances
        if not isinstance(instances, Mapping):
            return np.zeros(len(self.truth_instances), np.int64) if instances is None else instances
        return flatten_masks(instances, self.scores, len(self.truth_instances))


def labels_on_truth(truth: TruthScene, predicted: PredictedScene, preset: Preset) -> SceneLabels:
    """Bring a prediction onto the truth's vertices and its class names into the preset's list. Raises ValueError for
    labels or masks that do not fit the truth."""
    table = ClassTable.of(preset.vocabulary, truth.class_names)
    counts = truth.counts
    transfer = LabelTransfer(truth, predicted, preset)
    instances = transfer.instances()
    own_classes = table.numbers(predicted.class_names)
    classes = transfer.classes(table.numbers(predicted.vertex_class_names), own_classes, instances)
    truth_instances = np.asarray(truth.instances, np.int64)[counts]
    truth_classes = relabel(truth.classes, table.numbers(truth.class_names))[counts]
    instances = _only(instances, counts)
    classes = None if classes is None else classes[counts]
    if predicted.classes is not None and classes is not None and instances is not None:
        by_vertices = class_by_vertices(instances, classes)
        unnamed = {number: c for number, c in by_vertices.items() if number not in predicted.class_names}
        own_classes = by_vertices if preset.instance_class == "vertices" else own_classes | unnamed
    return SceneLabels(
        table,
        truth_instances,
        truth_classes,
        class_by_vertices(truth_instances, truth_classes),
        instances,
        classes,
        own_classes,
        _scores(instances, own_classes, predicted.scores, preset),
        predicted.name_probabilities,
    )


def _only(instances: InstanceLabels | None, counts: BoolArray) -> InstanceLabels | None:
    """The instances on the vertices that count, numbered among these."""
    if instances is None or counts.all():
        return instances
    if not isinstance(instances, Mapping):
        return instances[counts]
    return instances.among(counts)


def class_by_vertices(instances: InstanceLabels, classes: Int64Array) -> dict[int, int]:
    """The most frequent class of each instance's vertices, the lowest of equally frequent ones; none if unlabelled."""
    if isinstance(instances, Mapping):
        modes = {number: _mode(classes[mask]) for number, mask in instances.items()}
        return {number: mode for number, mode in modes.items() if mode}
    is_labelled = (instances > 0) & (classes > 0)
    span = int(classes.max(initial=0)) + 1
    pairs, counts = np.unique(instances[is_labelled] * span + classes[is_labelled], return_counts=True)
    order = np.lexsort((-(pairs % span), counts))  # the last one written stays
    return {int(pair) // span: int(pair) % span for pair in pairs[order]}


def _mode(classes: Int64Array) -> int:
    labelled = classes[classes > 0]
    return int(np.bincount(labelled).argmax()) if len(labelled) else 0


def _scores(
    instances: InstanceLabels | None, classes: Mapping[int, int], predicted_scores: Mapping[int, float], preset: Preset
) -> Mapping[int, float]:
    """The confidence of each prediction by the preset's rule."""
    if preset.score == "own" or instances is None:
        return predicted_scores
    sizes = _sizes(instances)
    if preset.score == "one":
        return dict.fromkeys(sizes, 1.0)
    largest: dict[int, int] = {}
    for number, size in sizes.items():
        class_number = classes.get(number, 0)
        largest[class_number] = max(size, largest.get(class_number, 1))
    return {number: size / largest[classes.get(number, 0)] for number, size in sizes.items()}


def _sizes(instances: InstanceLabels) -> dict[int, int]:
    if isinstance(instances, Mapping):
        return {number: len(mask) for number, mask in instances.items()}
    ids, counts = np.unique(instances[instances > 0], return_counts=True)
    return dict(zip(ids.tolist(), counts.tolist(), strict=True))
