"""Instances of a map with their names: what was given, or what its embedder thinks most probable."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from app.served_map.instance_models import ClassGuess, Instance, Kind
from razer.errors import BadInput
from razer.map_object import MapObject
from razer.models.stuff_names import is_stuff_name
from razer.panoptic_map import PanopticMap

N_GUESSES = 5
NAMED = 0.5  # an instance without a class is called what it is more likely than not
_LEAST_GUESS = 0.01


def instance_entries(panoptic: PanopticMap, n_crops: Callable[[MapObject], int]) -> tuple[Instance, ...]:
    """All instances and parts of a map, by id; `n_crops` tells how many pictures there are of one."""
    guesses = name_guesses(panoptic)
    parts: dict[int, list[int]] = {}
    for part in panoptic.parts:
        if part.part_of is not None:
            parts.setdefault(part.part_of, []).append(part.id)
    entries = [
        _entry(item, guesses.get(item.id, []), parts.get(item.id, []), n_crops(item))
        for item in (*panoptic.objects, *panoptic.parts)
    ]
    return tuple(sorted(entries, key=lambda entry: entry.id))


def name_guesses(panoptic: PanopticMap) -> dict[int, list[ClassGuess]]:
    """The names that each instance with embeddings may have, the most probable first; none without a text encoder."""
    ids = panoptic.embedding_table.ids.tolist()
    if not ids or panoptic.text_queries is None:
        return {}
    try:
        names = _names_to_tell_apart(panoptic)
        chances = panoptic.name_probabilities(names)
    except BadInput:  # pictures alone can be asked for here
        return {}
    best = np.argsort(-chances, axis=1, kind="stable")[:, :N_GUESSES]
    return {i: _guesses(names, chances[row], best[row].tolist()) for row, i in enumerate(ids)}


def _names_to_tell_apart(panoptic: PanopticMap) -> Sequence[str]:
    """The names that negative prompts have, and those that the map's instances bear."""
    assert panoptic.text_queries is not None
    queries = panoptic.text_queries
    own = {item.class_name for item in panoptic.objects if item.class_name and queries.knows(item.class_name)}
    return tuple(dict.fromkeys([*queries.negatives.names, *sorted(own)]))


def _guesses(names: Sequence[str], chances: np.ndarray, best: Sequence[int]) -> list[ClassGuess]:
    kept = [k for rank, k in enumerate(best) if rank == 0 or chances[k] >= _LEAST_GUESS]
    return [ClassGuess(name=names[k], probability=round(float(min(chances[k], 1.0)), 4)) for k in kept]


def _entry(item: MapObject, guesses: list[ClassGuess], parts: list[int], crops: int) -> Instance:
    name, probability = named(item.class_name, guesses)
    if item.is_named_by_hand and item.class_name is not None:
        probability = 1.0
        guesses = [ClassGuess(name=item.class_name, probability=1.0)]
    box = item.box
    return Instance(
        id=item.id,
        name=name,
        probability=probability,
        class_guesses=guesses,
        kind=kind_of(item, name),
        score=round(item.score, 4),
        center_m=_rounded(box.center),
        extent_m=_rounded(box.extent),
        orientation=[_rounded(row) for row in box.rotation],
        n_frames=item.observations,
        first_frame=item.first_frame,
        last_frame=item.last_frame,
        parts=parts,
        part_of=item.part_of,
        crops=crops,
        edited=item.is_edited,
        vertices=item.n_vertices,
    )


def named(given: str | None, guesses: Sequence[ClassGuess]) -> tuple[str | None, float | None]:
    """The name of an instance and its probability: the class it was given, or its best guess where that is likely."""
    if given is not None:
        return given, next((guess.probability for guess in guesses if guess.name == given), None)
    if guesses and guesses[0].probability >= NAMED:
        return guesses[0].name, guesses[0].probability
    return None, None


def kind_of(item: MapObject, name: str | None) -> Kind:
    """Whether an instance is a thing or stuff: as its masks said, or as its name says."""
    return "stuff" if item.is_stuff or (name is not None and is_stuff_name(name)) else "thing"


def _rounded(values: np.ndarray) -> list[float]:
    return [round(float(value), 5) for value in values]
