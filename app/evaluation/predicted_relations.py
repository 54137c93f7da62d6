"""Relations of a run's instances, as its scene graph would have them, for evaluation."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

from razer.metrics.class_table import normalized_name
from razer.metrics.scene_pair import PredictedScene
from razer.saved_map import load_map
from razer.semantics.scene_graph import map_relations
from razer.vocabulary import Category


def with_relations(predicted: PredictedScene, folder: Path, stuff: Collection[str]) -> PredictedScene:
    """The prediction of a run with the relations of its instances.

    Args:
        predicted: as read from the run, with the class names by which it is evaluated.
        folder: of the run.
        stuff: the names of classes that are stuff.
    """
    panoptic = load_map(folder)
    stuff = {normalized_name(name) for name in stuff}
    categories = {item.id: _category(predicted.class_names.get(item.id, ""), stuff) for item in panoptic.objects}
    edges = map_relations(panoptic, categories, panoptic.up_or_z)
    return replace(predicted, relations=tuple((edge.source, edge.relation, edge.target) for edge in edges))


def _category(name: str, stuff: Collection[str]) -> Category:
    return Category(0, name, 0, "", normalized_name(name) in stuff)
