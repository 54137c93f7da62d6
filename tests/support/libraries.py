"""Small made-up maps for libraries, with an embedder that knows any text."""

from __future__ import annotations

import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np

from razer.boxes.oriented_box import OrientedBox
from razer.class_votes import ClassVote
from razer.map_object import MapObject
from razer.mesh.labelled_mesh import LabelledMesh
from razer.panoptic_map import PanopticMap

WIDTH = 256
# As far apart as CLIP's texts and pictures are: what a picture shows is a small part of its vector.
_OF_TEXT, _OF_PICTURE, _COMMON = 0.3, 0.25, 0.88


def text_vector(text: str) -> np.ndarray:
    """The direction of what is meant, and what all texts have in common; templates' words hardly count."""
    return _unit(_OF_TEXT * _direction(text) + np.sqrt(1 - _OF_TEXT**2) * _direction("texts"))


def picture_vector(text: str, rng: np.random.Generator) -> np.ndarray:
    """What shows something, with noise of its own."""
    noise = np.sqrt(1 - _OF_PICTURE**2 - _COMMON**2) * _unit(rng.standard_normal(WIDTH))
    return _unit(_OF_PICTURE * _direction(text) + _COMMON * _direction("pictures") + noise)


def _direction(text: str) -> np.ndarray:
    words = [word for word in text.lower().strip(".").split() if word not in _FILLERS]
    vectors = [np.random.default_rng(zlib.crc32(word.encode())).standard_normal(WIDTH) for word in words or ["nothing"]]
    return _unit(np.mean([_unit(vector) for vector in vectors], axis=0))


def _unit(vector: np.ndarray) -> np.ndarray:
    return (vector / np.linalg.norm(vector)).astype(np.float32)


_FILLERS = {"a", "an", "the", "of", "photo", "in", "room", "cropped"}


class AnyText:
    """Knows any text; a picture's vector is that of the word that its brightness stands for."""

    def embed(self, frame, masks):
        return np.zeros((len(masks), WIDTH), np.float32)

    def embed_texts(self, texts):
        return np.stack([text_vector(text) for text in texts])

    def embed_region(self, rgb, mask):
        return picture_vector(WORDS[int(rgb[mask].mean()) % len(WORDS)], np.random.default_rng(0))


WORDS = (
    "chair",
    "mug",
    "lamp",
    "table",
    "sofa",
    "plant",
    "bicycle",
    "keyboard",
    "printer",
    "kettle",
    "guitar",
    "clock",
)


def made_map(seed: int, n: int = 12, *, votes: bool = False, words=WORDS) -> PanopticMap:
    """Instances that look like words, through noise, some with several hypotheses, some with parts."""
    rng = np.random.default_rng(seed)
    objects = tuple(_instance(i + 1, words[int(rng.integers(len(words)))], rng, votes) for i in range(n))
    parts = tuple(replace(_instance(n + i + 1, "cushion", rng, False), part_of=i + 1) for i in range(min(n, 2)))
    points = rng.uniform(0, 4, (60, 3)).astype(np.float32)
    labels = np.repeat(np.arange(1, 7), 10).astype(np.int32)
    mesh = LabelledMesh(points, np.zeros((60, 3), np.uint8), labels, np.zeros((0, 3), np.int32))
    vertex_parts = np.zeros(60, np.int32)
    return PanopticMap(objects, mesh, up=np.array([0.0, 0.0, 1.0]), parts=parts, vertex_parts=vertex_parts)


def _instance(number, word, rng, votes):
    count = int(rng.integers(1, 4))
    vectors = [picture_vector(word if i == 0 else str(rng.choice(WORDS)), rng) for i in range(count)]
    weights = np.sort(rng.dirichlet(np.ones(count)))[::-1]
    said = tuple(ClassVote(word, sector, 3, 1.5, 0.8) for sector in range(3)) if votes else ()
    center, extent = rng.uniform(0, 4, 3), rng.uniform(0.1, 1.5, 3)
    return MapObject(
        id=number,
        class_name=word if votes else None,
        score=float(rng.uniform(0.5, 1)),
        box=OrientedBox(center, np.eye(3), extent),
        n_voxels=100,
        n_vertices=10,
        observations=7,
        first_frame=1,
        last_frame=40,
        embeddings=np.stack(vectors),
        weights=weights,
        class_votes=said,
    )


def saved_run(folder: Path, panoptic: PanopticMap, embedder: str = "tests.support.libraries:AnyText") -> Path:
    """A folder with a map and the embedder that made it."""
    panoptic.save(folder)
    (folder / "config.toml").write_text(f'[embedder]\nname = "{embedder}"\n')
    return folder
