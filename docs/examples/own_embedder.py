"""An embedder of your own: embed(frame, masks), and embed_texts(texts) if it can be asked in words."""

import sys

import numpy as np

import razer
from data_tools import open_sequence

COLORS = {"red": (1, 0, 0), "green": (0, 1, 0), "blue": (0, 0, 1), "grey": (1, 1, 1)}


class MeanColor:
    """A mask's vector is the direction of its mean colour."""

    def embed(self, frame: razer.Frame, masks: razer.Masks) -> np.ndarray:
        """Unit vectors (N, 3), one for each mask."""
        return unit(np.array([frame.rgb[mask].mean(axis=0) for mask in masks.masks]).reshape(-1, 3))

    def embed_texts(self, texts: list[str]) -> np.ndarray:
        """Unit vectors (N, 3) of texts that name a colour."""
        return unit(np.array([next((v for k, v in COLORS.items() if k in text), (1, 1, 1)) for text in texts]))


def unit(vectors: np.ndarray) -> np.ndarray:
    """Rows of unit length."""
    return (vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9)).astype(np.float32)


mapper = razer.Mapper(segmenter="geometric", embedder=MeanColor())
for frame in open_sequence(sys.argv[1]):
    mapper.step(frame)
for hit in mapper.finish().query("something red", threshold=0.0).hits[:3]:
    print(hit.object.id, round(hit.score, 2))
