"""Panoptic labelling: classes of a vocabulary for the instances of a map; stuff of one class merges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from razer.arrays import Int32Array
from razer.errors import BadInput
from razer.mesh.labelled_mesh import LabelledMesh
from razer.panoptic_map import PanopticMap
from razer.query.name_probability import WITHIN_REACH
from razer.vocabulary import Category, Vocabulary


@dataclass(frozen=True)
class Label:
    """The class of an instance, the probability that it is this one of the classes given, and the next best class with
    its probability, if there are two."""

    id: int
    category: Category
    score: float
    runner_up: Category | None
    runner_up_score: float = 0.0

    @property
    def is_ambiguous(self) -> bool:
        """Whether the next best class is within reach."""
        return self.runner_up is not None and self.runner_up_score >= WITHIN_REACH * self.score


@dataclass(frozen=True)
class Segment:
    """A thing, or all stuff of one class: id, that of the instance or the lowest of the `instances` merged."""

    id: int
    category: Category
    score: float
    instances: tuple[int, ...]


def known_categories(panoptic: PanopticMap, vocabulary: Vocabulary) -> list[Category]:
    """The classes whose names the embedder of a map knows; raises BadInput if there is none."""
    known = known_names(panoptic, vocabulary.names, f"of the vocabulary {vocabulary.name}")
    return [vocabulary.by_name[name] for name in known]


def known_names(panoptic: PanopticMap, names: Sequence[str], whose: str) -> list[str]:
    """Those of some names that the embedder of a map knows; raises BadInput if there is none, saying `whose`."""
    if panoptic.text_queries is None:
        raise BadInput("no embedder is known for this map, so that names mean nothing")
    known = [name for name in names if panoptic.text_queries.knows(name)]
    if not known:
        raise BadInput(f"the embedder knows no name {whose}: choose another of either")
    return known


def label(panoptic: PanopticMap, categories: list[Category]) -> list[Label]:
    """The best of the given classes for each instance that has an embedding, by id. Raises BadInput."""
    if not len(panoptic.embedding_table):
        return []
    chances = panoptic.name_probabilities([category.name for category in categories])
    order = np.argsort(-chances, axis=1, kind="stable")
    labels = []
    for row, instance in enumerate(panoptic.embedding_table.ids.tolist()):
        best, *others = order[row, :2].tolist()
        chance, *second = chances[row, order[row, :2]].tolist()
        runner_up = (categories[others[0]], second[0]) if others else (None, 0.0)
        labels.append(Label(instance, categories[best], chance, *runner_up))
    return sorted(labels, key=lambda label: label.id)


def best_names(panoptic: PanopticMap, names: Sequence[str]) -> dict[int, str]:
    """The name that `label` gives each instance that has an embedding, by id. Raises BadInput."""
    return {i: name for i, (name, _) in probable_names(panoptic, names).items()}


def probable_names(panoptic: PanopticMap, names: Sequence[str]) -> dict[int, tuple[str, float]]:
    """The name that `label` gives each instance that has an embedding, with its probability, by id. Raises BadInput."""
    ids = panoptic.embedding_table.ids.tolist()
    if not ids:
        return {}
    chances = panoptic.name_probabilities(names)
    best = chances.argmax(axis=1).tolist()
    return {i: (names[k], float(row[k])) for i, k, row in zip(ids, best, chances, strict=True)}


def segments(labels: list[Label]) -> list[Segment]:
    """Things one by one, stuff of one class together; by id."""
    stuff: dict[str, list[Label]] = {}
    for instance in labels:
        if instance.category.stuff:
            stuff.setdefault(instance.category.name, []).append(instance)
    things = [Segment(i.id, i.category, i.score, (i.id,)) for i in labels if not i.category.stuff]
    merged = [
        Segment(group[0].id, group[0].category, max(i.score for i in group), tuple(i.id for i in group))
        for group in stuff.values()
    ]
    return sorted([*things, *merged], key=lambda segment: segment.id)


def segment_ids(mesh: LabelledMesh, scene_segments: list[Segment]) -> tuple[Int32Array, Int32Array]:
    """Segment (V,) and class number (V,) of each vertex; 0 = none. Instances without a class keep their id."""
    size = int(max([mesh.instances.max(initial=0), *(i for s in scene_segments for i in s.instances)])) + 1
    segment, category = np.arange(size, dtype=np.int32), np.zeros(size, np.int32)
    for each in scene_segments:
        segment[list(each.instances)], category[list(each.instances)] = each.id, each.category.id
    return segment[mesh.instances], category[mesh.instances]
