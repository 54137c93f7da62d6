"""An embedder over a table of real CLIP vectors: texts of names, and pictures of them seen through noise."""

from __future__ import annotations

import zlib
from pathlib import Path

import numpy as np

from razer.errors import BadInput


def unit_rows(vectors):
    wide = np.asarray(vectors, np.float32)
    return wide / np.linalg.norm(wide, axis=-1, keepdims=True)


class NamedVectors:
    """Masks with class names get the picture's vector of that name, blurred to a cosine; texts must be names."""

    def __init__(self, table: str, cosine: float = 0.7) -> None:
        with np.load(Path(table)) as arrays:
            self.known_names = tuple(map(str, arrays["names"]))
            self.text, self.image = unit_rows(arrays["text"]), unit_rows(arrays["image"])
            synonyms = [str(entry).split("|") for entry in arrays["synonyms"]]
        self.cosine = cosine
        self.row = {word: i for i, words in enumerate(synonyms) for word in reversed(words)}
        self.row |= {name: i for i, name in enumerate(self.known_names)}

    def embed_texts(self, texts):
        unknown = [text for text in texts if text not in self.row]
        if unknown:
            raise BadInput(f"the table does not know '{unknown[0]}'")
        return self.text[[self.row[text] for text in texts]]

    def embed(self, frame, masks):
        vectors = np.zeros((len(masks), self.image.shape[1]), np.float32)
        for number, (name, mask) in enumerate(zip(masks.class_names or (), masks.masks, strict=True)):
            rng = np.random.default_rng([frame.index, int(mask.argmax()), zlib.crc32(name.encode())])
            # What LVIS does not name (walls, floors) is like nothing in particular, but always the same.
            true = self.image[self.row[name]] if name in self.row else unit_rows(self.image.mean(axis=0))
            aside = rng.standard_normal(len(true))
            aside -= (aside @ true) * true
            vectors[number] = self.cosine * true + np.sqrt(1 - self.cosine**2) * aside / np.linalg.norm(aside)
        return vectors

    def embed_region(self, rgb, mask):
        return self.image[int(rgb[mask].mean()) % len(self.image)]
