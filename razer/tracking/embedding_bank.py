"""Embedding bank E_i of a track: a few hypotheses of what it is, each with its mass (RAZER section IV-E)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from razer.arrays import Float32Array, Float64Array
from razer.config import BankSettings
from razer.similarity.similarity_scale import SimilarityScale
from razer.tracking.embedding_clusters import EmbeddingClusters

# Mass at which a track counts as well observed, so that unlike embeddings are outliers and no new hypotheses.
WELL_OBSERVED_MASS = 2.0


class EmbeddingBank:
    """At most `settings.hypotheses` clusters with the weighted sum of their observations and its mass W_j.

    Noisy observations of one thing are less alike than `settings.similarity` and fill several clusters. What is read
    are hypotheses e_j, clusters of one thing merged, with confidence c_j = W_j / sum W.

    Similarities are mean cosines to the observations of a hypothesis, which do not grow with their number as that to
    their mean does, in units of unlike ... same."""

    def __init__(self, settings: BankSettings, dimension: int, scale: SimilarityScale | None = None) -> None:
        """An empty bank; `scale` is that of the embedder, shared by all banks of a map; without one, units are
        cosines."""
        self.settings = settings
        self.scale = SimilarityScale() if scale is None else scale
        self._clusters = EmbeddingClusters.none(dimension)
        self._hypotheses = self._clusters
        self.outliers = 0

    @property
    def embeddings(self) -> Float32Array:
        """Hypotheses (J, D) float32 of unit length, the strongest first."""
        return self._hypotheses.directions.astype(np.float32)

    @property
    def confidences(self) -> Float64Array:
        """c_j (J,), adding up to 1, in the order of `embeddings`."""
        masses = self._hypotheses.masses
        return masses / masses.sum() if len(masses) else masses

    def settled(self) -> tuple[Float32Array, Float64Array]:
        """Embeddings (J, D) and confidences (J,) for queries, without those of a single observation, the strongest
        first. Association still wants these, as a view that was observed once may come again."""
        merge = self.settings.merge_hypotheses
        clusters = self._clusters.settled(self.scale.calibrated) if merge else self._clusters.by_mass()
        return clusters.directions.astype(np.float32), clusters.masses / max(clusters.masses.sum(), 1e-12)

    @property
    def mass(self) -> float:
        """Confidence mass of all observations fused so far."""
        return float(self._clusters.masses.sum())

    @property
    def peak_confidence(self) -> float:
        """max c_j in [0, 1] as the paper has it: c_j adds up (RAZER eq. 14), and no more than 1 counts."""
        return float(min(1.0, self._hypotheses.masses.max(initial=0.0)))

    @property
    def means(self) -> Float64Array:
        """Mean observations (J, D) of the hypotheses, of length 1 or less, in the order of `embeddings`."""
        return self._hypotheses.means

    def similarity(self, embedding: Float32Array) -> float:
        """Highest similarity of a unit vector (D,) to any hypothesis (RAZER section IV-I), in units of unlike ... same;
        0 while empty."""
        return self.scale.units(float((self.means @ embedding).max())) if len(self._hypotheses) else 0.0

    def probability_same(self, embedding: Float32Array) -> float:
        """Probability that a unit vector (D,) is of the same thing as the bank, beforehand as likely as not."""
        return float(1 / (1 + np.exp(-self.scale.log_odds(self.similarity(embedding)))))

    def log_odds_same(self, other: EmbeddingBank) -> float:
        """ln P(same thing) / P(unlike things) of two banks: the mean of the likelihood ratios of all pairs of their
        hypotheses, each by its confidences, so that one wrong vector among many speaks for little; 0 where one is
        empty."""
        cosines = self._hypotheses.mean_cosines(other._hypotheses)
        if not cosines.size:
            return 0.0
        ratios = np.exp(self.scale.log_odds(self.scale.units(cosines)))
        return float(np.log(self.confidences @ ratios @ other.confidences))

    def add(self, embedding: Float32Array, confidence: float) -> None:
        """Take in one observation (RAZER eqs. 13 and 14)."""
        confidence = max(confidence, 1e-6)
        self._take(EmbeddingClusters.of(embedding, confidence))
        self._hypotheses = self._read()

    def absorb(self, other: EmbeddingBank) -> None:
        """Take in the clusters of a fused duplicate, with their mass."""
        for row in range(len(other._clusters)):
            self._take(other._clusters.select([row]))
        self._hypotheses = self._read()
        self.outliers += other.outliers

    def _take(self, new: EmbeddingClusters) -> None:
        self._clusters = self._with(new) if len(self._clusters) else new

    def _with(self, new: EmbeddingClusters) -> EmbeddingClusters:
        """The clusters after one more: merged with one of them, beside them, in place of one, or an outlier."""
        clusters = self._clusters
        similarities = self._similarities(new)
        nearest = int(similarities.argmax())
        if similarities[nearest] > self.settings.similarity or self.settings.hypotheses == 1:
            return clusters.merged(nearest, new)
        may_refuse = self.settings.outlier > -1 and self.mass > WELL_OBSERVED_MASS
        if may_refuse and similarities[nearest] < self.settings.outlier:
            self.outliers += 1
            return clusters
        if len(clusters) < self.settings.hypotheses:
            return clusters.joined(new)
        if self.settings.when_full == "drop":
            return clusters
        if new.masses[0] > clusters.masses.min():
            return clusters.select(np.arange(len(clusters)) != clusters.masses.argmin()).joined(new)
        return clusters.merged(nearest, new)

    def _similarities(self, new: EmbeddingClusters) -> Float64Array:
        """Of one more cluster to each of ours (J,), as sigma_sim is compared with: in units, or cosines s_j (RAZER eq.
        13)."""
        if self.settings.similarity_scale == "cosine":
            return (self._clusters.directions @ new.directions.T)[:, 0]
        return self.scale.units(self._clusters.mean_cosines(new)[:, 0])

    def _read(self) -> EmbeddingClusters:
        """The hypotheses that the clusters are read as, the strongest first."""
        if self.settings.merge_hypotheses:
            return self._clusters.distinct(self.scale.calibrated)
        return self._clusters.by_mass()


def bank_similarity(banks: Sequence[EmbeddingBank], embeddings: Float32Array) -> Float64Array:
    """Highest similarity of each of (N, D) unit vectors to each of M banks of one scale, (M, N), in units of unlike ...
    same."""
    if not banks or len(embeddings) == 0:
        return np.zeros((len(banks), len(embeddings)))
    sizes = [len(bank.means) for bank in banks]
    cosines = np.concatenate([bank.means for bank in banks]) @ embeddings.T
    return banks[0].scale.units(np.maximum.reduceat(cosines, np.r_[0, np.cumsum(sizes)[:-1]], axis=0))


def same_thing_doubt(banks: Sequence[EmbeddingBank], embeddings: Float32Array) -> Float64Array:
    """1 - P(same | similarity) of each of (N, D) unit vectors and each of M >= 1 banks of one scale, (M, N) in [0, 1];
    beforehand both are as likely."""
    log_odds = banks[0].scale.log_odds(bank_similarity(banks, embeddings))
    return 1 - 1 / (1 + np.exp(-log_odds))


def euclidean_distance(banks: Sequence[EmbeddingBank], embeddings: Float32Array) -> Float64Array:
    """S (M, N) in [0, 2]: distance of each of (N, D) unit vectors to the nearest e_j of each of M >= 1 banks, as RAZER
    eqs. 8 and 14 have it: the mean of the observations, which is shorter than 1."""
    means = np.concatenate([bank.means for bank in banks])
    squares = 1 + (means**2).sum(axis=1, keepdims=True) - 2 * means @ embeddings.T.astype(np.float64)
    distances = np.sqrt(np.maximum(squares, 0.0))
    sizes = [len(bank.means) for bank in banks]
    nearest: Float64Array = np.minimum.reduceat(distances, np.r_[0, np.cumsum(sizes)[:-1]], axis=0)
    return nearest
