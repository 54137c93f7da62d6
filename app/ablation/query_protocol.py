"""Protocol of the retrieval ablation: objects observed many times with noise, then queried by name.

Of each draw 60 names are in the map and 60 others are not. An object is observed 20 times as the vector of its
picture, blurred to a cosine of 0.7; a share of the observations may be of another object, as where masks spill over.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.ablation.exemplars import Exemplars
from razer.arrays import BoolArray, Float32Array, Float64Array, IndexArray
from razer.config import BankSettings
from razer.metrics.instances.precision_recall import Curve, precision_recall
from razer.query.embedding_table import EmbeddingTable
from razer.query.naming import ranked_names
from razer.query.ranking import PRESENT, NegativePrompts, TextRanking
from razer.similarity.similarity_scale import SimilarityScale
from razer.tracking.embedding_bank import EmbeddingBank

Banks = dict[int, tuple[Float32Array, Float64Array]]


@dataclass(frozen=True)
class Protocol:
    """Objects and absent names of a draw, observations of each object, cosine of an observation to what it is of,
    and the share of observations that are of another object."""

    n_objects: int = 60
    n_observations: int = 20
    cosine: float = 0.7
    neighbour_share: float = 0.0


@dataclass(frozen=True)
class QueryScore:
    """Shares of a draw: instances whose own name comes first of all names, or among five (top1, top5), and first by the
    highest cosine alone (cosine_top1); texts whose instance comes first (text_top1). best (2n,) is the best score of
    each query, present (2n,) whether it is in the map."""

    top1: float
    top5: float
    cosine_top1: float
    text_top1: float
    best: Float64Array
    present: BoolArray


def noisy_observations(
    exemplars: Exemplars, rows: IndexArray, rng: np.random.Generator, protocol: Protocol
) -> Float32Array:
    """Noisy embeddings of objects.

    Args:
        exemplars: names with their vectors.
        rows: (n,) the rows of `exemplars` that are in the map.
        rng: the source of noise.
        protocol: number of observations, their noise and how many are of a neighbour.

    Returns:
        (n objects, n observations, D) of unit length.
    """
    n, count = len(rows), protocol.n_observations
    neighbour = rows[(np.arange(n) + rng.integers(1, n, n)) % n]
    is_neighbour = rng.permuted(np.tile(np.arange(count) < round(count * protocol.neighbour_share), (n, 1)), axis=1)
    source_vectors = exemplars.image[np.where(is_neighbour, neighbour[:, None], rows[:, None])]
    orthogonal = rng.standard_normal(source_vectors.shape).astype(np.float32)
    orthogonal -= (orthogonal * source_vectors).sum(axis=2, keepdims=True) * source_vectors
    orthogonal /= np.linalg.norm(orthogonal, axis=2, keepdims=True)
    return protocol.cosine * source_vectors + np.float32(np.sqrt(1 - protocol.cosine**2)) * orthogonal


def banks_of(observations: Float32Array, settings: BankSettings) -> Banks:
    """The bank of each object after all its observations, which count alike.

    Each round of one observation an object is what a frame is to a map: the scale learns from it."""
    scale = SimilarityScale()
    banks = [EmbeddingBank(settings, observations.shape[2], scale) for _ in observations]
    for views in observations.transpose(1, 0, 2):
        same = [bank.means[0] @ view for bank, view in zip(banks, views, strict=True) if len(bank.means)]
        scale.observe((views @ views.T)[np.triu_indices(len(views), 1)], np.array(same))
        for bank, view in zip(banks, views, strict=True):
            bank.add(view, 0.5)
    return {number: bank.settled() for number, bank in enumerate(banks)}


def clean_banks(exemplars: Exemplars, rows: IndexArray) -> Banks:
    """Banks that hold the pictures' own vectors."""
    return {number: (exemplars.image[[row]], np.ones(1)) for number, row in enumerate(rows)}


def query_score(exemplars: Exemplars, banks: Banks, present: IndexArray, absent: IndexArray) -> QueryScore:
    """Query every name of the table, by the program's own ranking.

    Args:
        exemplars: names with their vectors.
        banks: embeddings and weights of each object.
        present: (n,) rows of the names that are in the map, in the order of the objects.
        absent: (n,) rows of names that are not.
    """
    table, objects = EmbeddingTable.of(banks), np.arange(len(present))
    ranking = TextRanking(table, NegativePrompts(exemplars.names, exemplars.text))
    is_own = ranked_names(table, exemplars.text) == present[:, None]
    cosines = table.best((table.vectors @ exemplars.text.T).astype(np.float64))
    queries = np.concatenate([present, absent])
    return QueryScore(
        top1=float(is_own[:, 0].mean()),
        top5=float(is_own[:, :5].any(axis=1).mean()),
        cosine_top1=float((cosines.argmax(axis=1) == present).mean()),
        text_top1=float((ranking.log_ratios(exemplars.text[present]).argmax(axis=0) == objects).mean()),
        best=ranking.scores(exemplars.text[queries]).max(axis=0),
        present=np.arange(len(queries)) < len(present),
    )


def presence_curve(scores: list[QueryScore]) -> Curve:
    """Precision over recall of the answer "present", over all queries of all draws."""
    best, present = (np.concatenate([getattr(s, part) for s in scores]) for part in ("best", "present"))
    return precision_recall(best, present, 0)


def presence_at(scores: list[QueryScore], threshold: float = PRESENT) -> tuple[float, float]:
    """Precision and recall of the answer "present" for best scores of at least `threshold`."""
    best, present = (np.concatenate([getattr(s, part) for s in scores]) for part in ("best", "present"))
    is_predicted = best >= threshold
    n_correct = float((is_predicted & present).sum())
    return n_correct / max(is_predicted.sum(), 1), n_correct / present.sum()
