"""Vectors of pictures and of names of the same classes, from a file; classes of our worlds that LVIS lacks by a
substitute."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

import numpy as np

from razer.arrays import Float32Array, Float64Array
from razer.errors import BadInput
from razer.files import read_npz
from razer.models.name_vectors.name_table import NameVectorTable, bare_name

# Each class of the synthetic worlds that LVIS has under no name, and the entry that stands for it: the same thing under
# another name where there is one, else something that looks like it and that no other class of the worlds uses.
SUBSTITUTES = {
    "bag": "tote bag",
    "blinds": "awning",
    "bookshelf": "bookcase",
    "ceiling": "chandelier",
    "clothes": "sportswear",
    "clothes dryer": "heater",
    "coat rack": "coatrack",
    "coffee kettle": "kettle",
    "column": "lamppost",
    "computer tower": "router (computer equipment)",
    "counter": "kitchen table",
    "dish rack": "spice rack",
    "door": "doorknob",
    "doorframe": "hinge",
    "end table": "footstool",
    "floor": "mat (gym equipment)",
    "headphones": "headset",
    "keyboard": "computer keyboard",
    "kitchen cabinet": "cupboard",
    "laptop": "laptop computer",
    "mat": "doormat",
    "microwave": "microwave oven",
    "mini fridge": "cooler (for food)",
    "monitor": "monitor (computer equipment) computer monitor",
    "mouse": "mouse (computer equipment)",
    "nightstand": "drawer",
    "office chair": "recliner",
    "paper": "notepad",
    "paper towel roll": "paper towel",
    "picture": "painting",
    "plant": "flower arrangement",
    "potted plant": "flowerpot",
    "range hood": "fume hood",
    "recycling bin": "dumpster",
    "shelf": "pegboard",
    "shower": "shower head",
    "sign": "street sign",
    "speaker": "speaker (stero equipment)",
    "storage bin": "toolbox",
    "stuffed animal": "teddy bear",
    "tissue box": "tissue paper",
    "tv stand": "record player",
    "wall": "tapestry",
    "whiteboard": "signboard",
    "window": "window box (for plants)",
}
_BRACKET = re.compile(r"\s*\([^)]*\)")


class ExemplarTable(NameVectorTable):
    """A NumPy archive as NameVectorTable reads it that also has `image` (N, D): mean vectors of pictures of each class.

    Names are found as there, by SUBSTITUTES, and without what LVIS says in brackets. Raises BadInput.
    """

    def __init__(self, file: str | Path) -> None:
        super().__init__(file)
        self.images = _images(self.files[0], self.vectors.shape)
        rows = dict(self._rows)
        self._rows |= {name: rows[other] for name, other in SUBSTITUTES.items() if name not in rows and other in rows}
        for word, row in rows.items():
            self._rows.setdefault(_BRACKET.sub("", word), row)

    @property
    def known_names(self) -> tuple[str, ...]:
        """The names of the file, and those that have a substitute in it."""
        return (*self.names, *(name for name in SUBSTITUTES if name in self._rows and name not in self.names))

    def row(self, name: str) -> int:
        """The row of a class; of one that the file lacks a row that its name draws."""
        row = self._rows.get(bare_name(name))
        if row is not None:
            return row
        return int.from_bytes(hashlib.sha256(bare_name(name).encode()).digest()[:8], "little") % len(self.names)


def _images(file: Path, shape: tuple[int, ...]) -> Float64Array:
    """The unit vectors (N, D) of pictures; raises BadInput."""
    try:
        images: Float32Array = read_npz(file, ["image"])["image"].astype(np.float32)
    except ValueError as error:
        raise BadInput(f"{file} has no vectors of pictures (image) beside those of names: {error}") from error
    norms = np.linalg.norm(images, axis=-1, keepdims=True)
    if images.shape != shape or not np.isfinite(norms).all() or not norms.all():
        raise BadInput(f"{file}: image is {images.shape} where text is {shape}, or has vectors of no length")
    return (images / norms).astype(np.float64)
