"""Scene graph of a map by the names that its instances have now, given or guessed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from app.served_map.instance_models import Instance
from razer.panoptic_map import PanopticMap
from razer.semantics.labelling import Label, segments
from razer.semantics.scene_graph import scene_graph
from razer.vocabulary import Category


def named_graph(panoptic: PanopticMap, entries: Sequence[Instance]) -> dict[str, Any]:
    """{nodes, edges} as `razer label` writes them, by the names of now."""
    return scene_graph(panoptic, segments(_labels(panoptic, entries)), panoptic.up_or_z)


def _labels(panoptic: PanopticMap, entries: Sequence[Instance]) -> list[Label]:
    """A class for each instance; things without a name are things all the same, and stand and lie on others."""
    by_id = {entry.id: entry for entry in entries}
    numbers: dict[str, int] = {}
    labels = []
    for item in panoptic.objects:
        entry = by_id[item.id]
        name = entry.name
        number = numbers.setdefault(name, len(numbers) + 1)
        category = Category(number, name, 0, "", entry.kind == "stuff")
        labels.append(Label(item.id, category, entry.probability or 0.0, None))
    return labels
