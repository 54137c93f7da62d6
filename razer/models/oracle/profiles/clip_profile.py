"""Profile `clip`: vectors as CLIP gives of crops: real exemplars, context, and errors of thing, side and frame."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from razer.arrays import BoolArray, Float32Array, Float64Array
from razer.frame import Frame, Masks
from razer.models.oracle.profiles.exemplar_table import ExemplarTable
from razer.models.oracle.profiles.mask_shapes import grown_window
from razer.models.oracle.profiles.visible_things import SECTORS, SEEN_AS, VisibleThings, Window, largest

CONTEXT = 0.25  # weight of what the crop shows beside the mask
CROP_MARGIN = 0.1  # of the longer side of a mask, by which its crop is larger on each side
MEAN_COSINE = 0.62  # of a vector to its exemplar
_OF_THING, _OF_SECTOR, _OF_FRAME = range(3)


class ClipProfile:
    """Unit vectors of masks by what the instance ids say they show, whatever a segmenter calls it.

    Each is the exemplar of the class, blended with those of what lies beside it in the crop, and with an error of which
    a third of the variance is the thing's own, a third comes with the side it is seen from, and a third with the frame.
    Errors are random sums of the differences between exemplars, so strong that the mean cosine is 0.62.

    Args:
        table: file with names, text and image (see ExemplarTable).
        seed: of all random draws.
    """

    def __init__(self, table: str | Path, seed: int = 0) -> None:
        self.seed = seed
        self.table = ExemplarTable(table)
        images = self.table.images
        self._differences = (images - images.mean(axis=0)) / np.sqrt(len(images))

    def embed(self, frame: Frame, masks: Masks) -> Float32Array:
        """A unit vector for each mask, (N, D) float32; raises BadInput where the frame has no instance ids."""
        vectors = np.zeros((len(masks), self.table.images.shape[1]), np.float32)
        if len(masks):
            things = VisibleThings.of(frame, "embedder")
            for number, mask in enumerate(masks.masks):
                vectors[number] = self._of_mask(things, mask)
        return vectors

    def exemplar(self, name: str) -> Float64Array:
        """The unit vector (D,) of pictures of a class."""
        vector: Float64Array = self.table.images[self.table.row(name)]
        return vector

    @property
    def unrelated_cosine(self) -> float:
        """The mean cosine of vectors of two classes: errors are independent and cancel."""
        of_exemplars = float(np.square(self.table.images.mean(axis=0)).sum())
        return of_exemplars * (MEAN_COSINE / (1 - CONTEXT + CONTEXT * of_exemplars)) ** 2

    def _of_mask(self, things: VisibleThings, mask: BoolArray) -> Float64Array:
        window = _crop(mask)
        covered, beside = (things.shares(pixels, window) for pixels in (mask[window], ~mask[window]))
        thing = largest(covered)
        blend = self._blend(things, covered or beside)
        if beside:
            blend = (1 - CONTEXT) * blend + CONTEXT * self._blend(things, beside)
        vector = blend + self._error_scale(things.name(thing), blend) * self._error(things, thing, mask)
        return vector / np.linalg.norm(vector)

    def _error_scale(self, name: str, blend: Float64Array) -> float:
        """How strong the error is, so that the mean cosine to the exemplar is 0.62 whatever the context."""
        length_squared = (self.exemplar(name) @ blend / MEAN_COSINE) ** 2
        return float(np.sqrt(max(length_squared - blend @ blend, 0) / np.square(self._differences).sum()))

    def _blend(self, things: VisibleThings, shares: Mapping[int, float]) -> Float64Array:
        """The mean exemplar of what some pixels show, by their shares; of something unknown where it is nothing."""
        exemplars = [share * self.exemplar(things.name(thing)) for thing, share in (shares or {0: 1.0}).items()]
        return np.sum(exemplars, axis=0)

    def _error(self, things: VisibleThings, thing: int, mask: BoolArray) -> Float64Array:
        start_deg = np.random.default_rng([self.seed, SEEN_AS, thing]).uniform(0, 360 / SECTORS)
        sector = things.sector(thing, start_deg) if thing else 0
        # Which masks reach the embedder depends on filters: the mask itself is the key.
        of_mask = int(mask.argmax()), int(np.count_nonzero(mask))
        keys = ((_OF_THING, thing), (_OF_SECTOR, thing, sector), (_OF_FRAME, thing, things.frame.index, *of_mask))
        weights = sum(
            np.random.default_rng([self.seed, SEEN_AS, *key]).standard_normal(len(self._differences)) for key in keys
        )
        error: Float64Array = weights @ self._differences / np.sqrt(len(keys))
        return error


def _crop(mask: BoolArray) -> Window:
    """The window of the image that a crop of the mask shows."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return slice(0, 0), slice(0, 0)
    box = slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)
    longer = max(side.stop - side.start for side in box)
    return grown_window(box, round(CROP_MARGIN * longer), mask.shape)
