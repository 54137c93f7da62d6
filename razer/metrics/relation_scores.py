"""Relations of instances against the truth: precision and recall by relation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from razer.arrays import Int64Array
from razer.metrics.instances.instance_ap import nanmean
from razer.metrics.instances.matching import count_overlaps

Triple = tuple[int, str, int]
Node = tuple[str, int]
Edge = tuple[Node, str, Node]
MIN_IOU = 0.5


@dataclass(frozen=True, slots=True)
class RelationCounts:
    """Of one scene, by relation: true relations that were shown, those of them whose both ends were found, predicted
    relations, and those of them that are true."""

    true: Counter[str]
    found: Counter[str]
    predicted: Counter[str]
    right: Counter[str]
    recalled: Counter[str]


@dataclass(frozen=True, slots=True)
class RelationScene:
    """Instances of V vertices, truth (V,) and predicted (V,), 0 for none; the relations of both; stuff: class of each
    true instance that is stuff; min_region: vertices of the smallest true instance that counts as shown."""

    truth: Int64Array
    predicted: Int64Array
    true_relations: Sequence[Triple]
    predicted_relations: Sequence[Triple]
    stuff: Mapping[int, int]
    min_region: int


def count_relations(scene: RelationScene) -> RelationCounts:
    """Count true and predicted relations of the kinds that the truth states.

    A predicted instance stands for the true one that it overlaps by more than MIN_IOU, whatever its class. Stuff of one
    class is one node on both sides: an instance that lies for the most part on the truth's floors stands for the floor.
    A predicted relation is right if the truth has it between the instances that its ends stand for; one with an end
    that stands for nothing, such as a double, is wrong. A true relation counts if the vertices that were seen of both
    its ends, not the number of those that were found, suffice.
    """
    sizes = Counter(scene.truth[scene.truth > 0].tolist())
    node_of = {number: _node(number, scene.stuff) for number in sizes}
    partner = _partners(scene)
    shown = {number for number, size in sizes.items() if size >= scene.min_region}
    all_true = _edges(scene.true_relations, node_of)
    true = _edges([t for t in scene.true_relations if t[0] in shown and t[2] in shown], node_of)
    kinds = {relation for _, relation, _ in scene.true_relations}
    triples = [triple for triple in scene.predicted_relations if triple[1] in kinds]
    ends = {number for a, _, b in triples for number in (a, b)}
    predicted = _edges(triples, {number: partner.get(number, ("nothing", number)) for number in ends})
    nodes = set(partner.values())
    return RelationCounts(
        _by_relation(true),
        _by_relation(edge for edge in true if edge[0] in nodes and edge[2] in nodes),
        _by_relation(predicted),
        _by_relation(predicted & all_true),
        _by_relation(predicted & true),
    )


def _node(number: int, stuff: Mapping[int, int]) -> Node:
    return ("stuff", stuff[number]) if number in stuff else ("thing", number)


def _edges(triples: Iterable[Triple], node_of: Mapping[int, Node]) -> set[Edge]:
    return {(node_of[a], relation, node_of[b]) for a, relation, b in triples if a in node_of and b in node_of}


def _partners(scene: RelationScene) -> dict[int, Node]:
    """What each predicted instance stands for."""
    overlaps = count_overlaps(scene.truth, scene.predicted)
    truth_ids, iou = overlaps.truth_ids.tolist(), overlaps.iou
    kinds = np.array([scene.stuff.get(number, -1) for number in truth_ids])
    nodes: dict[int, Node] = {}
    for column, number in enumerate(overlaps.predicted_ids.tolist()):
        for kind in set(scene.stuff.values()):
            if 2 * overlaps.counts[kinds == kind, column].sum() > overlaps.predicted_sizes[column]:
                nodes[number] = ("stuff", kind)
        rows = np.flatnonzero((iou[:, column] > MIN_IOU) & (kinds < 0))
        if len(rows):
            nodes[number] = ("thing", truth_ids[rows[0]])
    return nodes


def _by_relation(edges: Iterable[Edge]) -> Counter[str]:
    return Counter(relation for _, relation, _ in edges)


def relation_scores(scenes: Collection[RelationCounts]) -> dict[str, Any] | None:
    """Precision, recall and their counts over all scenes, overall and by_relation; None without scenes."""
    if not scenes:
        return None
    total = {name: sum((getattr(s, name) for s in scenes), Counter[str]()) for name in RelationCounts.__slots__}
    names = sorted({name for counter in total.values() for name in counter})
    by_relation = {name: _scores({key: counter[name] for key, counter in total.items()}) for name in names}
    return _scores({key: counter.total() for key, counter in total.items()}) | {"by_relation": by_relation}


def _scores(counts: Mapping[str, int]) -> dict[str, Any]:
    return {
        "precision": _share(counts["right"], counts["predicted"]),
        "recall": _share(counts["recalled"], counts["true"]),
        "ends_found": _share(counts["found"], counts["true"]),
        "n_true": counts["true"],
        "n_predicted": counts["predicted"],
        "n_right": counts["right"],
    }


def _share(part: int, whole: int) -> float:
    return nanmean([part / whole]) if whole else float("nan")
