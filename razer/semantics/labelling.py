"""Panoptic labelling: classes of a vocabulary for the instances of a map; stuff of one class merges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from razer.arrays import Int32Array
from razer.errors import BadInput
from razer.panoptic_map import PanopticMap
from razer.vocabulary import Category, Vocabulary
from razer.volume.mesh_extraction import LabelledMesh


@dataclass(frozen=True)
class Label:
    """The class of an instance, the probability that its name fits, and the next best class, if there are two."""

    id: int
    category: Category
    score: float
    runner_up: Category | None


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
    texts = panoptic.text_vectors([category.name for category in categories])
    order = panoptic.ranked_names(texts)
    if not len(order):
        return []
    scores = panoptic.text_ranking.scores(texts)
    labels = []
    for row, instance in enumerate(panoptic.embedding_table.ids.tolist()):
        best, *others = order[row, :2].tolist()
        second = categories[others[0]] if others else None
        labels.append(Label(instance, categories[best], float(scores[row, best]), second))
    return sorted(labels, key=lambda label: label.id)


def best_names(panoptic: PanopticMap, names: Sequence[str]) -> dict[int, str]:
    """The name that `label` gives each instance that has an embedding, by id, without the probability that it fits,
    which needs the negative prompts. Raises BadInput."""
    order = panoptic.ranked_names(panoptic.text_vectors(names))
    return {int(i): names[int(row[0])] for i, row in zip(panoptic.embedding_table.ids, order, strict=True)}


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
