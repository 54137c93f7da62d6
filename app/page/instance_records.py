"""Instances of a map as the page and the interface of the server tell them: plain JSON values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from razer.arrays import Float64Array
from razer.class_votes import name_evidence, usual_score
from razer.errors import BadInput
from razer.map_object import MapObject
from razer.models.stuff_names import is_stuff_name
from razer.panoptic_map import PanopticMap
from razer.query.kinds import all_kinds
from razer.query.phrases import plain
from razer.semantics.scene_graph import map_relations
from razer.vocabulary import Category

MAX_GUESSES = 5
LEAST_GUESS = 0.005
Guess = tuple[str, float]


def instance_records(panoptic: PanopticMap) -> list[dict[str, Any]]:
    """One record for each instance and each part, by id: what it is called and how surely, where it lies (metres; the
    columns of `orientation` are the axes of its box in the world), and which frames saw it."""
    guesses = class_guesses(panoptic)
    counts = np.bincount(panoptic.mesh.instances.clip(min=0), minlength=1)
    records = []
    for item in sorted([*panoptic.objects, *panoptic.parts], key=lambda each: each.id):
        vertices = int(counts[item.id]) if item.id < len(counts) and item.part_of is None else item.n_vertices
        parts = [part.id for part in panoptic.parts_of(item.id)]
        records.append(_record(item, guesses.get(item.id, []), parts, vertices))
    return records


def _record(item: MapObject, guesses: Sequence[Guess], parts: list[int], vertices: int) -> dict[str, Any]:
    name = item.class_name or (guesses[0][0] if guesses else "part" if item.part_of else "thing")
    probability = 1.0 if item.is_named_by_hand else dict(guesses).get(name)
    return {
        "id": item.id,
        "name": name,
        "probability": probability,
        "class_guesses": [{"name": guess, "probability": chance} for guess, chance in guesses],
        "kind": "stuff" if item.is_stuff or is_stuff_name(name) else "thing",
        "score": round(item.score, 4),
        "center_m": item.box.center.round(4).tolist(),
        "extent_m": item.box.extent.round(4).tolist(),
        "orientation": item.box.rotation.round(5).tolist(),
        "n_frames": item.observations,
        "first_frame": item.first_frame,
        "last_frame": item.last_frame,
        "parts": parts,
        "part_of": item.part_of,
        "crops": len(item.views),
        "edited": item.is_edited,
        "vertices": vertices,
    }


def class_guesses(panoptic: PanopticMap) -> dict[int, list[Guess]]:
    """The likeliest names of each instance with their probabilities, the best first, among all names that were given in
    the map; by what the segmenter said where the embedder cannot weigh it, none where nobody said anything."""
    names = sorted({o.class_name for o in panoptic.objects if o.class_name}
                   | {vote.name for o in panoptic.objects for vote in o.class_votes})  # fmt: skip
    if not names:
        return {}
    try:
        known = [name for name in names if panoptic.text_queries is not None and panoptic.text_queries.knows(name)]
        if known:
            ids, chances = panoptic.embedding_table.ids.tolist(), panoptic.name_probabilities(known)
            return {i: _best(known, row) for i, row in zip(ids, chances, strict=True)}
    except BadInput:  # the embedder's files are not here
        pass
    usual = usual_score(vote for o in panoptic.objects for vote in o.class_votes)
    return {o.id: _voted(o, usual) for o in panoptic.objects if o.class_votes}


def _best(names: Sequence[str], chances: Float64Array) -> list[Guess]:
    rows = np.argsort(-chances, kind="stable")[:MAX_GUESSES].tolist()
    return [(names[row], round(float(chances[row]), 4)) for row in rows if chances[row] >= LEAST_GUESS]


def _voted(item: MapObject, usual: float) -> list[Guess]:
    evidence = name_evidence(item.class_votes, usual)
    total = sum(evidence.values())
    return _best(list(evidence), np.array(list(evidence.values())) / total) if total > 0 else []


def relation_records(panoptic: PanopticMap) -> list[dict[str, Any]]:
    """{subject, relation, object} by ids, of all instances, named or not; each part is "part of" its whole."""
    categories = {
        o.id: Category(0, o.class_name or "", 0, "", o.is_stuff or is_stuff_name(o.class_name or ""))
        for o in panoptic.objects
    }
    edges = map_relations(panoptic, categories, panoptic.up_or_z) if panoptic.objects else []
    told = [{"subject": edge.source, "relation": str(edge.relation), "object": edge.target} for edge in edges]
    return told + [{"subject": p.id, "relation": "part of", "object": p.part_of} for p in panoptic.parts]


def kinds_of(names: Sequence[str]) -> dict[str, list[str]]:
    """The words of the kinds that each name belongs to ("chair": "seat", "furniture"), purposes among them; names of no
    kind are left out."""
    found: dict[str, list[str]] = {}
    for name in names:
        words = [word for kind in all_kinds() if plain(name) in kind.names for word in (*kind.words, *kind.purposes)]
        if words:
            found[name] = list(dict.fromkeys(words))
    return found
