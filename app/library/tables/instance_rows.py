"""Rows of the table of instances: one for each embedding hypothesis, with what filters ask of its instance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa

from app.library.tables.model_identity import METADATA, ModelIdentity
from app.library.tables.room_place import RoomPlaces
from razer.map_object import MapObject
from razer.panoptic_map import PanopticMap
from razer.query.phrases import plain, singulars

VECTOR = "vector"
_VOTE = pa.struct(
    [
        ("name", pa.string()),
        ("sector", pa.int8()),
        ("frames", pa.int32()),
        ("weight", pa.float32()),
        ("score", pa.float32()),
    ]
)
_COLUMNS: dict[str, pa.DataType] = {
    "run": pa.string(),
    "generation": pa.int64(),
    "scene": pa.string(),
    "id": pa.int32(),
    "hypothesis": pa.int16(),
    "share": pa.float32(),
    "class": pa.string(),
    "names": pa.list_(pa.string()),
    "score": pa.float32(),
    "stuff": pa.bool_(),
    "part_of": pa.int32(),
    "edited": pa.bool_(),
    "named_by_hand": pa.bool_(),
    "observations": pa.int32(),
    "first_frame": pa.int32(),
    "last_frame": pa.int32(),
    "best_frame": pa.int32(),
    "first_view_s": pa.float64(),
    "last_view_s": pa.float64(),
    "height_m": pa.float32(),
    "width_m": pa.float32(),
    "depth_m": pa.float32(),
    "volume_m3": pa.float32(),
    "above_floor_m": pa.float32(),
    "room_x": pa.float32(),
    "room_y": pa.float32(),
    "box": pa.list_(pa.float32(), 15),
    "votes": pa.list_(_VOTE),
    "provenance": pa.string(),
}


@dataclass(frozen=True)
class Entry:
    """What a library notes of a map as a whole: run, the folder by its full path; scene; generation, larger for each
    later addition; provenance, JSON."""

    run: str
    scene: str
    generation: int
    provenance: str


def schema_of(model: ModelIdentity) -> pa.Schema:
    """The columns of the table of a model: vectors as float16, null where an instance has none."""
    fields = [*_COLUMNS.items(), (VECTOR, pa.list_(pa.float16(), model.dimension))]
    return pa.schema(fields, metadata={METADATA: model.to_bytes()})


def rows_of(panoptic: PanopticMap, entry: Entry, model: ModelIdentity) -> pa.Table:
    """The rows of all instances and parts of a map, those of an instance together, its strongest hypothesis first."""
    places = RoomPlaces.of(panoptic)
    items = [item for item in (*panoptic.objects, *panoptic.parts) if len(item.embeddings) or item.is_named_by_hand]
    rows = [row for item in items for row in _rows_of_instance(item, places)]
    for number, row in enumerate(rows):
        provenance = None if number else entry.provenance  # once for each map
        row.update(run=entry.run, scene=entry.scene, generation=entry.generation, provenance=provenance)
    columns = [pa.array([row[name] for row in rows], kind) for name, kind in _COLUMNS.items()]
    return pa.table([*columns, vector_column(items, model.dimension)], schema=schema_of(model))


def vector_column(items: Sequence[MapObject], dimension: int) -> pa.Array:
    """The embeddings of instances, a row each; an instance without any has a row that is null."""
    blank = np.zeros((1, dimension), np.float32)
    parts = [item.embeddings if len(item.embeddings) else blank for item in items]
    is_null = np.concatenate(
        [np.zeros(0, bool), *(np.full(len(p), not len(i.embeddings)) for i, p in zip(items, parts, strict=True))]
    )
    values = np.concatenate([blank[:0], *parts]).astype(np.float16)
    return pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), dimension, mask=pa.array(is_null))


def _rows_of_instance(item: MapObject, places: RoomPlaces) -> Iterator[dict[str, Any]]:
    facts = _facts(item) | places.facts(item.box)
    votes = [
        {"name": v.name, "sector": v.sector, "frames": v.frames, "weight": v.weight, "score": v.score}
        for v in item.class_votes
    ]
    shares: Sequence[float | None] = item.weights.tolist() or [None]
    for number, share in enumerate(shares):
        yield {**facts, "hypothesis": number, "share": share, "votes": None if number else votes}


def _facts(item: MapObject) -> dict[str, Any]:
    stamps = [view.stamp for view in item.views if view.stamp is not None]
    box = item.box
    return {
        "id": item.id,
        "class": item.class_name,
        "names": _words(item),
        "score": item.score,
        "stuff": item.is_stuff,
        "part_of": item.part_of,
        "edited": item.is_edited,
        "named_by_hand": item.is_named_by_hand,
        "observations": item.observations,
        "first_frame": item.first_frame,
        "last_frame": item.last_frame,
        "best_frame": item.views[0].frame if item.views else None,
        "first_view_s": min(stamps, default=None),
        "last_view_s": max(stamps, default=None),
        "box": [*box.center.tolist(), *box.rotation.ravel().tolist(), *box.extent.tolist()],
    }


def _words(item: MapObject) -> list[str]:
    """What an instance was called, in all forms that a text is compared with; of a name given by hand its last words,
    too, by which it is a kind: a "red office chair" is a chair."""
    called = {vote.name for vote in item.class_votes} | ({item.class_name} if item.class_name else set())
    if item.is_named_by_hand and item.class_name:
        words = plain(item.class_name).split()
        called |= {" ".join(words[start:]) for start in range(len(words))}
    return sorted({form for name in called for form in singulars(plain(name))})
