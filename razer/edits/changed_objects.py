"""Instances after an edit: what is known of several pooled, and of one whose surface is another."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from razer.arrays import Float32Array, Float64Array
from razer.boxes.oriented_box import OrientedBox
from razer.class_votes import ClassVote
from razer.detection.best_views import best_views
from razer.map_object import MapObject

HYPOTHESES = 3  # of an instance, as the map keeps them


def pooled(kept: MapObject, others: Sequence[MapObject], points: Float64Array) -> MapObject:
    """One instance of several, whose surface is at `points` (N, 3): the kept one's id, its name or else that of the
    largest that has one, and what all of them know, in whatever order the others are named."""
    others = sorted(others, key=lambda item: (-item.n_vertices, item.id))
    every = [kept, *others]
    embeddings, weights = _bank(every)
    named = next((item for item in every if item.class_name), kept)
    return replace(
        kept,
        class_name=named.class_name,
        is_named_by_hand=named.is_named_by_hand,
        is_edited=True,
        score=max(item.score for item in every),
        box=OrientedBox.of_surface(points) if len(points) else kept.box,
        n_voxels=sum(item.n_voxels for item in every),
        n_vertices=len(points),
        observations=max(item.observations for item in every),
        first_frame=min(item.first_frame for item in every),
        last_frame=max(item.last_frame for item in every),
        embeddings=embeddings,
        weights=weights,
        views=best_views(view for item in every for view in item.views),
        class_votes=_votes(vote for item in every for vote in item.class_votes),
    )


def _bank(items: Sequence[MapObject]) -> tuple[Float32Array, Float64Array]:
    """The strongest hypotheses (J, D) of all, and their weights (J,) by surface, adding up to 1."""
    items = sorted((item for item in items if len(item.weights)), key=lambda item: item.id)
    if not items:
        return np.zeros((0, 0), np.float32), np.zeros(0)
    vectors = np.concatenate([item.embeddings for item in items])
    weights = np.concatenate([max(item.n_vertices, 1) * item.weights for item in items])
    best = np.argsort(-weights, kind="stable")[:HYPOTHESES]
    return vectors[best], weights[best] / weights[best].sum()


def _votes(votes: Iterable[ClassVote]) -> tuple[ClassVote, ...]:
    """Votes of several instances as those of one: of a name in a sector the frames and weights together."""
    by_key: dict[tuple[str, int], list[ClassVote]] = {}
    for vote in votes:
        by_key.setdefault((vote.name, vote.sector), []).append(vote)
    summed = []
    for (name, sector), group in sorted(by_key.items()):
        weight = sum(vote.weight for vote in group)
        score = sum(vote.weight * vote.score for vote in group) / max(weight, 1e-12)
        summed.append(ClassVote(name, sector, sum(vote.frames for vote in group), weight, score))
    return tuple(summed)
