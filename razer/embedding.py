"""The embedding bank E_i of a track: a few hypotheses of what it is, each with its mass (section III-D)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from razer.config import BankSettings

Vectors = NDArray[np.float32]
# Mass at which a track counts as well seen, so that strangers are outliers instead of new hypotheses.
WELL_SEEN_MASS = 2.0


class EmbeddingBank:
    """At most `settings.hypotheses` unit vectors e_j with masses W_j; confidence c_j = W_j / sum W."""

    def __init__(self, settings: BankSettings, dimension: int) -> None:
        self.settings = settings
        self._sums = np.zeros((0, dimension), np.float64)
        self._masses = np.zeros(0)
        self.outliers = 0

    @property
    def embeddings(self) -> Vectors:
        """Hypotheses (J, D) float32 of unit length, the strongest first."""
        return _unit(self._sums[self._order]).astype(np.float32)

    @property
    def confidences(self) -> NDArray[np.float64]:
        """c_j (J,), adding up to 1, in the order of `embeddings`."""
        total = self._masses.sum()
        return self._masses[self._order] / total if total > 0 else self._masses[self._order]

    @property
    def mass(self) -> float:
        """Confidence mass of all observations fused so far."""
        return float(self._masses.sum())

    @property
    def _order(self) -> NDArray[np.intp]:
        return np.argsort(-self._masses, kind="stable")

    def similarity(self, embedding: Vectors) -> float:
        """Highest cosine of a unit vector (D,) to any hypothesis (section III-H); 0 while empty."""
        return float((_unit(self._sums) @ embedding).max()) if len(self._sums) else 0.0

    def add(self, embedding: Vectors, confidence: float) -> None:
        """Take in one observation (eqs. 12 and 13)."""
        confidence = max(confidence, 1e-6)
        if len(self._sums) == 0:
            return self._append(embedding * confidence, confidence)
        cosines = _unit(self._sums) @ embedding
        nearest = int(cosines.argmax())
        if cosines[nearest] > self.settings.similarity or self.settings.hypotheses == 1:
            self._merge(nearest, embedding * confidence, confidence)
        elif cosines[nearest] < self.settings.outlier and self.mass > WELL_SEEN_MASS:
            self.outliers += 1
        elif len(self._sums) < self.settings.hypotheses:
            self._append(embedding * confidence, confidence)
        elif confidence > self._masses.min():
            weakest = int(self._masses.argmin())
            self._sums[weakest], self._masses[weakest] = embedding * confidence, confidence
        else:
            self._merge(nearest, embedding * confidence, confidence)
        return None

    def absorb(self, other: EmbeddingBank) -> None:
        """Take in the hypotheses of a fused duplicate, with their mass."""
        for vector, mass in zip(_unit(other._sums), other._masses, strict=True):
            self.add(vector.astype(np.float32), float(mass))
        self.outliers += other.outliers

    def _append(self, weighted: NDArray, mass: float) -> None:
        self._sums = np.vstack([self._sums, weighted])
        self._masses = np.append(self._masses, mass)

    def _merge(self, slot: int, weighted: NDArray, mass: float) -> None:
        self._sums[slot] += weighted
        self._masses[slot] += mass


def bank_similarity(banks: Sequence[EmbeddingBank], embeddings: Vectors) -> NDArray[np.float64]:
    """Highest cosine of each of (N, D) unit vectors to each of M banks, (M, N)."""
    if not banks or len(embeddings) == 0:
        return np.zeros((len(banks), len(embeddings)))
    sizes = [len(bank.embeddings) for bank in banks]
    cosines = np.concatenate([bank.embeddings for bank in banks]) @ embeddings.T
    return np.maximum.reduceat(cosines, np.r_[0, np.cumsum(sizes)[:-1]], axis=0)


def _unit(vectors: NDArray) -> NDArray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)
