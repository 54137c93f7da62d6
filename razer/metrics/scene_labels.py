"""A prediction laid over the truth: what both say of the truth's vertices that count, by a preset's rules."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from razer.metrics.class_table import ClassTable
from razer.metrics.preset import Preset
from razer.metrics.scene_pair import PredictedScene, TruthScene
from razer.metrics.transfer import nearest_vertices

Labels = NDArray[np.int64]
Masks = Labels | Mapping[int, Labels]
"""Instance ids (V,), or id -> vertex numbers (M,) where instances may overlap."""


@dataclass(frozen=True, slots=True)
class SceneLabels:
    """V evaluated vertices. truth_instances, truth_classes (V,); predicted_instances as ids or masks, None where the
    prediction has none; predicted_classes (V,), None where it names none; classes are numbers of the table, 0 for none.
    The classes of true and predicted instances are given by id, the unknown ones left out. scores by predicted id."""

    table: ClassTable
    truth_instances: Labels
    truth_classes: Labels
    truth_instance_classes: Mapping[int, int]
    predicted_instances: Masks | None
    predicted_classes: Labels | None
    predicted_instance_classes: Mapping[int, int]
    scores: Mapping[int, float]

    @property
    def single_instances(self) -> Labels:
        """One predicted instance for each vertex (V,): where masks overlap that of the higher score, then lower id."""
        found = self.predicted_instances
        if not isinstance(found, Mapping):
            return np.zeros(len(self.truth_instances), np.int64) if found is None else found
        return painted(found, self.scores, len(self.truth_instances))


def lay_over(truth: TruthScene, predicted: PredictedScene, preset: Preset) -> SceneLabels:
    """Bring a prediction onto the truth's vertices and its class names into the preset's list. Raises ValueError for
    labels or masks that do not fit the truth."""
    table = ClassTable.of(preset.vocabulary, truth.class_names)
    counts = truth.counts
    instances = _instances(truth, predicted, preset)
    own_classes = table.numbers(predicted.class_names)
    classes = _classes(truth, predicted, preset, table, own_classes, instances)
    truth_instances = np.asarray(truth.instances, np.int64)[counts]
    truth_classes = renumbered(truth.classes, table.numbers(truth.class_names))[counts]
    instances = _only(instances, counts)
    classes = None if classes is None else classes[counts]
    if predicted.classes is not None and classes is not None and instances is not None:
        by_vertices = _class_by_vertices(instances, classes)
        unnamed = {number: c for number, c in by_vertices.items() if number not in predicted.class_names}
        own_classes = by_vertices if preset.instance_class == "vertices" else own_classes | unnamed
    return SceneLabels(
        table,
        truth_instances,
        truth_classes,
        _class_by_vertices(truth_instances, truth_classes),
        instances,
        classes,
        own_classes,
        _scores(instances, own_classes, predicted.scores, preset),
    )


def renumbered(labels: NDArray[np.integer], numbers: Mapping[int, int]) -> Labels:
    """Each label (V,) replaced by its number, 0 where it has none."""
    known, place = np.unique(labels, return_inverse=True)
    return np.array([numbers.get(int(label), 0) for label in known], np.int64)[place].reshape(len(labels))


def painted(masks: Mapping[int, Labels], scores: Mapping[int, float], n_vertices: int) -> Labels:
    """One id for each of V vertices: of the masks over it the one with the highest score, then the lowest id."""
    image = np.zeros(n_vertices, np.int64)
    for number in sorted(masks, key=lambda i: (scores.get(i, 1.0), -i)):
        image[masks[number]] = number
    return image


def _instances(truth: TruthScene, predicted: PredictedScene, preset: Preset) -> Masks | None:
    """The predicted instances on all of the truth's vertices."""
    n_vertices = len(truth.vertices)
    if predicted.masks is not None:
        return {number: _numbers(mask, n_vertices, number) for number, mask in sorted(predicted.masks.items())}
    if predicted.instances is None:
        return None
    if predicted.vertices is not None:
        near = nearest_vertices(predicted.vertices, truth.vertices, preset.instance_k, preset.instance_max_m)
        return near.labels(predicted.instances)
    _check_length(predicted.instances, n_vertices)
    if preset.instance_k == 1:
        return np.asarray(predicted.instances, np.int64)
    near = nearest_vertices(truth.vertices, truth.vertices, preset.instance_k, preset.instance_max_m)
    return near.labels(predicted.instances)


def _numbers(mask: NDArray, n_vertices: int, number: int) -> Labels:
    """The vertices of a mask given as their numbers or as one truth value each, each once."""
    image = np.zeros(n_vertices, np.bool_)
    if mask.dtype == np.bool_:
        _check_length(mask, n_vertices)
    elif len(mask) and not 0 <= mask.min() <= mask.max() < n_vertices:
        raise ValueError(f"mask {number} names vertices that the truth's {n_vertices} do not have")
    image[mask] = True
    return np.flatnonzero(image)


def _check_length(labels: NDArray, n_vertices: int) -> None:
    if len(labels) != n_vertices:
        raise ValueError(f"{len(labels)} predicted labels for {n_vertices} true vertices: one of each, please")


def _classes(
    truth: TruthScene,
    predicted: PredictedScene,
    preset: Preset,
    table: ClassTable,
    own_classes: Mapping[int, int],
    instances: Masks | None,
) -> Labels | None:
    """The predicted classes of all of the truth's vertices."""
    if predicted.classes is not None:
        labels = renumbered(predicted.classes, table.numbers(predicted.vertex_class_names))
    elif predicted.instances is not None and predicted.class_names:
        labels = renumbered(predicted.instances, own_classes)
    elif isinstance(instances, Mapping) and predicted.class_names:
        labels = renumbered(painted(instances, predicted.scores, len(truth.vertices)), own_classes)
    else:
        return None
    source = truth.vertices if predicted.vertices is None else predicted.vertices
    _check_length(labels, len(source))
    if predicted.vertices is None and preset.semantic_k == 1:
        return labels
    voters = None if preset.unlabelled_vote else labels > 0
    return nearest_vertices(source, truth.vertices, preset.semantic_k, preset.semantic_max_m, voters).labels(labels)


def _only(instances: Masks | None, counts: NDArray[np.bool_]) -> Masks | None:
    """The instances on the vertices that count, numbered among these."""
    if instances is None or counts.all():
        return instances
    if not isinstance(instances, Mapping):
        return instances[counts]
    place = np.cumsum(counts) - 1
    return {number: place[mask[counts[mask]]] for number, mask in instances.items()}


def _class_by_vertices(instances: Masks, classes: Labels) -> dict[int, int]:
    """The most frequent class of each instance's vertices, the lowest of equally frequent ones; none if unlabelled."""
    if isinstance(instances, Mapping):
        modes = {number: _mode(classes[mask]) for number, mask in instances.items()}
        return {number: mode for number, mode in modes.items() if mode}
    own = (instances > 0) & (classes > 0)
    span = int(classes.max(initial=0)) + 1
    pairs, counts = np.unique(instances[own] * span + classes[own], return_counts=True)
    order = np.lexsort((-(pairs % span), counts))  # the last one written stays
    return {int(pair) // span: int(pair) % span for pair in pairs[order]}


def _mode(classes: Labels) -> int:
    labelled = classes[classes > 0]
    return int(np.bincount(labelled).argmax()) if len(labelled) else 0


def _scores(
    instances: Masks | None, classes: Mapping[int, int], own: Mapping[int, float], preset: Preset
) -> Mapping[int, float]:
    """The confidence of each prediction by the preset's rule."""
    if preset.score == "own" or instances is None:
        return own
    sizes = _sizes(instances)
    if preset.score == "one":
        return dict.fromkeys(sizes, 1.0)
    largest: dict[int, int] = {}
    for number, size in sizes.items():
        kind = classes.get(number, 0)
        largest[kind] = max(size, largest.get(kind, 1))
    return {number: size / largest[classes.get(number, 0)] for number, size in sizes.items()}


def _sizes(instances: Masks) -> dict[int, int]:
    if isinstance(instances, Mapping):
        return {number: len(mask) for number, mask in instances.items()}
    ids, counts = np.unique(instances[instances > 0], return_counts=True)
    return dict(zip(ids.tolist(), counts.tolist(), strict=True))
