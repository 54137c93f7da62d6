"""embeddings.npz: the embedding banks of a map's instances, written and read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from razer.arrays import Float32Array, Float64Array
from razer.errors import BadInput
from razer.files import read_npz
from razer.map_object import MapObject

FORMAT = 1


def write_embeddings_npz(path: Path, objects: Sequence[MapObject]) -> None:
    """The embedding banks: ids (R,), embeddings (R, D), weights (R,), a row for each hypothesis."""
    objects = [o for o in objects if len(o.embeddings)]
    width = objects[0].embeddings.shape[1] if objects else 0
    np.savez_compressed(
        path,
        format=FORMAT,
        ids=np.concatenate([np.full(len(o.weights), o.id, np.int32) for o in objects] or [np.zeros(0, np.int32)]),
        embeddings=np.concatenate([o.embeddings for o in objects] or [np.zeros((0, width), np.float32)]),
        weights=np.concatenate([o.weights for o in objects] or [np.zeros(0)]),
    )


def read_embeddings_npz(path: Path) -> dict[int, tuple[Float32Array, Float64Array]]:
    """{id: embeddings (J, D), weights (J,)}; raises BadInput or ValueError for a file that is none."""
    bank = read_npz(path, ["ids", "embeddings", "weights"])
    ids, embeddings, weights = bank["ids"], bank["embeddings"], bank["weights"]
    if ids.ndim != 1 or embeddings.ndim != 2 or not len(ids) == len(embeddings) == len(weights) == weights.size:
        raise BadInput(f"{path}: its arrays are not of one length")
    if not all(np.issubdtype(rows.dtype, np.floating) and np.isfinite(rows).all() for rows in (embeddings, weights)):
        raise BadInput(f"{path}: its embeddings or weights are no finite numbers")
    known, first = np.unique(ids, return_index=True)
    if not len(known):
        return {}
    # The rows of an id lie together.
    order = np.argsort(first)
    parts = [np.split(rows, np.sort(first)[1:]) for rows in (embeddings, weights)]
    return {int(i): (e, w) for i, e, w in zip(known[order], *parts, strict=True)}
