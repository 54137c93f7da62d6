"""A map out of a library: its instances as they lie in the table, ready to be asked as `razer query` asks a map."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa

from app.library.tables.instance_rows import VECTOR
from razer.arrays import Float32Array, Float64Array, FloatArray
from razer.boxes.oriented_box import OrientedBox
from razer.class_votes import ClassVote
from razer.map_object import MapObject
from razer.query.map_queries import MapQueries
from razer.query.text_queries import TextQueryEncoder

_FACTS = ("id", "class", "score", "stuff", "part_of", "edited", "named_by_hand", "votes")
COLUMNS = (
    "run",
    "generation",
    "scene",
    "hypothesis",
    "share",
    "box",
    VECTOR,
    *_FACTS,
)  # of the table, that it is made of


@dataclass(frozen=True)
class StoredMap:
    """The instances and parts of one map, and what answers for them."""

    run: str
    scene: str
    generation: int
    queries: MapQueries

    @classmethod
    def of(cls, rows: pa.Table, encoder: TextQueryEncoder | None) -> StoredMap:
        """From all rows (at least one) of a map, of one generation, with the columns `COLUMNS`, in any order."""
        rows = rows.sort_by([("id", "ascending"), ("hypothesis", "ascending")])
        vectors, shares = _vectors(rows), np.nan_to_num(rows["share"].to_numpy()).astype(np.float64)
        starts = np.flatnonzero(rows["hypothesis"].to_numpy() == 0)
        ends = np.append(starts[1:], rows.num_rows)
        first_rows, items = rows.take(starts), []
        boxes = _lists(first_rows["box"]).astype(np.float64)
        facts_of = zip(*(first_rows[name].to_pylist() for name in _FACTS), strict=True)
        for facts, box, start, end in zip(facts_of, boxes, starts.tolist(), ends.tolist(), strict=True):
            has_vectors = bool(shares[start] > 0)
            own = slice(start, end if has_vectors else start)
            items.append(_instance(dict(zip(_FACTS, facts, strict=True)), box, vectors[own], shares[own]))
        objects, parts = (tuple(i for i in items if (i.part_of is None) == whole) for whole in (True, False))
        first = {name: rows[name][0].as_py() for name in ("run", "scene", "generation")}
        return cls(**first, queries=MapQueries(objects, parts, encoder))


def _vectors(rows: pa.Table) -> Float32Array:
    """The vectors (R, D), of unit length again after rounding; zeros where there are none."""
    vectors = np.nan_to_num(_lists(rows[VECTOR])).astype(np.float32)
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-6)


def _lists(column: pa.ChunkedArray) -> FloatArray:
    """A column of lists of W numbers each, (R, W)."""
    whole = column.combine_chunks()
    width = whole.type.list_size
    flat: FloatArray = whole.values.slice(whole.offset * width, len(whole) * width).to_numpy(zero_copy_only=False)
    return flat.reshape(-1, width)


def _instance(facts: dict[str, Any], box: Float64Array, vectors: Float32Array, weights: Float64Array) -> MapObject:
    """What questions need of an instance; how often it was seen, and when, stays in the table."""
    votes = (ClassVote(v["name"], v["sector"], v["frames"], v["weight"], v["score"]) for v in facts["votes"] or ())
    return MapObject(
        id=facts["id"],
        class_name=facts["class"],
        score=facts["score"],
        box=OrientedBox(box[:3], box[3:12].reshape(3, 3), box[12:]),
        n_voxels=0,
        n_vertices=0,
        observations=0,
        first_frame=0,
        last_frame=0,
        embeddings=vectors,
        weights=weights,
        is_stuff=facts["stuff"],
        class_votes=tuple(votes),
        part_of=facts["part_of"],
        is_edited=facts["edited"],
        is_named_by_hand=facts["named_by_hand"],
    )
