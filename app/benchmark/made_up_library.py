"""Maps made up for the benchmark of libraries: instances as many as wanted, of exemplars seen through noise."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pyarrow as pa

from app.ablation.exemplars import Exemplars
from app.library.tables.instance_rows import Entry, rows_of
from app.library.tables.model_identity import ModelIdentity
from razer.arrays import Float32Array, IndexArray
from razer.boxes.oriented_box import OrientedBox
from razer.class_votes import ClassVote
from razer.detection.best_views import BestView, Region
from razer.map_object import MapObject
from razer.mesh.labelled_mesh import LabelledMesh
from razer.panoptic_map import PanopticMap

INSTANCES_OF_MAP = 100
_COSINE = 0.7
_NAMES, _DIMENSION = 1200, 512


def made_up_exemplars() -> Exemplars:
    """Names without meaning, whose texts and pictures are about as alike as CLIP's are."""
    rng = np.random.default_rng(0)
    common, own = _units(rng.standard_normal((2, _DIMENSION))), _units(rng.standard_normal((_NAMES, _DIMENSION)))
    text, image = _units(common[0] + 0.6 * own), _units(common[1] + 0.45 * own)
    names = tuple(f"thing {number}" for number in range(_NAMES))
    return Exemplars(names, tuple(frozenset([name]) for name in names), text, image)


def noisy(vectors: Float32Array, rng: np.random.Generator) -> Float32Array:
    """Vectors (N, D) at a cosine of 0.7 to those given."""
    aside = rng.standard_normal(vectors.shape, dtype=np.float32)
    aside -= (aside * vectors).sum(axis=1, keepdims=True) * vectors
    return _COSINE * vectors + np.float32(np.sqrt(1 - _COSINE**2)) * _units(aside)


def rows_of_maps(
    exemplars: Exemplars, model: ModelIdentity, numbers: range, rng: np.random.Generator
) -> Iterator[pa.Table]:
    """The rows of each of some maps, by their numbers."""
    for number in numbers:
        rows = rng.integers(len(exemplars.names), size=INSTANCES_OF_MAP)
        entry = Entry(f"/maps/{number:06d}/run", f"scene {number // 3}", number + 1, '{"instances": 100}')
        yield rows_of(made_up_map(exemplars, rows, rng), entry, model)


def made_up_map(exemplars: Exemplars, rows: IndexArray, rng: np.random.Generator) -> PanopticMap:
    """A map of instances of some exemplars; every third was called by its name, from three sides."""
    vectors = noisy(exemplars.image[rows], rng)
    objects = [_instance(i + 1, exemplars.names[row], vectors[i : i + 1], rng) for i, row in enumerate(rows.tolist())]
    return PanopticMap(tuple(objects), LabelledMesh.empty(), up=np.array([0.0, 0.0, 1.0]))


def _instance(number: int, name: str, vectors: Float32Array, rng: np.random.Generator) -> MapObject:
    angle = rng.uniform(0, np.pi)
    rotation = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    frame = int(rng.integers(2000))
    is_named = number % 3 == 0
    scores = rng.uniform(0.4, 0.9, 3)
    votes = [ClassVote(name, side, int(rng.integers(1, 30)), float(s), float(s)) for side, s in enumerate(scores)]
    return MapObject(
        id=number,
        class_name=name if is_named else None,
        score=float(rng.uniform(0.3, 1)),
        box=OrientedBox(rng.uniform(0, 8, 3), rotation, rng.uniform(0.05, 2, 3)),
        n_voxels=1000,
        n_vertices=1000,
        observations=int(rng.integers(3, 400)),
        first_frame=frame,
        last_frame=frame + int(rng.integers(10, 900)),
        embeddings=vectors,
        weights=np.ones(1),
        views=(BestView(frame + 5, Region((0, 0, 9, 9), 80, True), (frame + 5) / 30),),
        class_votes=tuple(votes) if is_named else (),
    )


def _units(vectors: np.ndarray) -> Float32Array:
    return (vectors / np.linalg.norm(vectors, axis=1, keepdims=True)).astype(np.float32)
