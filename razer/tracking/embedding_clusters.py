"""Clusters of unit vectors as running sums, with the directions beneath the noise of single observations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from razer.arrays import BoolArray, Float64Array
from razer.similarity.similarity_scale import CalibratedScale

# Similarity of two clusters, their noise removed, in units of unlike ... same, from which they are one thing. Swept on
# CLIP vectors with a third of a neighbour's (`razer ablate --queries`): name top-1 59.3 % at 0.5, 60.1 % at 0.75,
# 58.5 % at 0.9.
SAME_THING_UNITS = 0.75


@dataclass(frozen=True)
class EmbeddingClusters:
    """J clusters of weighted observations: sums (J, D) of weight x unit vector, masses (J,) sums of the weights,
    squares (J,) sums of the squared weights."""

    sums: Float64Array
    masses: Float64Array
    squares: Float64Array

    @classmethod
    def none(cls, dimension: int) -> EmbeddingClusters:
        """No clusters."""
        return cls(np.zeros((0, dimension)), np.zeros(0), np.zeros(0))

    @classmethod
    def of(cls, embedding: NDArray, weight: float) -> EmbeddingClusters:
        """One cluster with one observation (D,)."""
        return cls(embedding[None].astype(np.float64) * weight, np.array([weight]), np.array([weight**2]))

    def __len__(self) -> int:
        return len(self.masses)

    @cached_property
    def means(self) -> Float64Array:
        """Weighted means (J, D): their product with a vector is its mean cosine to the observations."""
        return self.sums / self.masses[:, None]

    @cached_property
    def directions(self) -> Float64Array:
        """Unit vectors (J, D)."""
        return self.sums / np.maximum(np.linalg.norm(self.sums, axis=1, keepdims=True), 1e-12)

    def select(self, rows: Sequence[int] | NDArray) -> EmbeddingClusters:
        """Some of the clusters, in the given order."""
        return EmbeddingClusters(self.sums[rows], self.masses[rows], self.squares[rows])

    def joined(self, other: EmbeddingClusters) -> EmbeddingClusters:
        """These clusters and those of another, one after the other."""
        return EmbeddingClusters(
            np.concatenate([self.sums, other.sums]),
            np.concatenate([self.masses, other.masses]),
            np.concatenate([self.squares, other.squares]),
        )

    def merged(self, row: int, other: EmbeddingClusters) -> EmbeddingClusters:
        """The one cluster of another merged into the cluster `row`."""
        is_row = (np.arange(len(self)) == row).astype(np.float64)
        return EmbeddingClusters(
            self.sums + is_row[:, None] * other.sums,
            self.masses + is_row * other.masses,
            self.squares + is_row * other.squares,
        )

    def by_mass(self) -> EmbeddingClusters:
        """The same, the largest first."""
        return self.select(np.argsort(-self.masses, kind="stable"))

    def mean_cosines(self, other: EmbeddingClusters) -> Float64Array:
        """The mean cosine (J, K) between the observations of each cluster and those of each cluster of another."""
        return self.means @ other.means.T

    def coherence(self, of_single: float) -> Float64Array:
        """The mean cosine (J,) between different observations of a cluster, in (0, 1]; `of_single` where there is only
        one.

        |sum|^2 holds the cosine of each observation with itself, whose share is taken out."""
        pairs = self.masses**2 - self.squares
        has_several = self.has_several
        cosine = ((self.sums**2).sum(axis=1) - self.squares) / np.where(has_several, pairs, 1.0)
        return np.clip(np.where(has_several, cosine, of_single), 1e-3, 1.0)

    @property
    def has_several(self) -> BoolArray:
        """Which clusters (J,) hold more than one observation."""
        return self.masses**2 - self.squares > 1e-9 * self.masses**2

    def settled(self, scale: CalibratedScale) -> EmbeddingClusters:
        """`distinct` clusters, those of a single observation merged into the most alike: alone they are mostly noise.
        Where there are no others, this is the running mean."""
        clusters = self.distinct(scale)
        while len(clusters) > 1 and not clusters.has_several.all():
            row = int(np.flatnonzero(~clusters.has_several)[-1])
            rest, single = clusters.select(np.arange(len(clusters)) != row), clusters.select([row])
            clusters = rest.merged(int(rest.mean_cosines(single).argmax()), single).distinct(scale)
        return clusters

    def distinct(self, scale: CalibratedScale) -> EmbeddingClusters:
        """Clusters of one thing merged, the most alike first; those left by mass, the largest first.

        Alike is what two clusters have in common, measured by what the observations of each have in common."""
        clusters, typical = self, max(scale.same.mean, 1e-3)
        while len(clusters) > 1:
            noise = np.sqrt(clusters.coherence(of_single=typical) / typical)
            cosine = clusters.mean_cosines(clusters) / np.outer(noise, noise)
            cosine[np.tril_indices(len(clusters))] = -np.inf
            first, second = np.unravel_index(cosine.argmax(), cosine.shape)
            if scale.units(float(cosine[first, second])) < SAME_THING_UNITS:
                break
            rest = clusters.select(np.arange(len(clusters)) != second)
            clusters = rest.merged(int(first), clusters.select([int(second)]))
        return clusters.by_mass()
