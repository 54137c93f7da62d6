"""The answer *present* of many maps is wrong no more often than that of one."""

from __future__ import annotations

import numpy as np
import pytest

from app.ablation.exemplars import Exemplars
from app.library.presence import picture_threshold_among, threshold_among
from razer.query.embedding_table import EmbeddingTable
from razer.query.ranking import PRESENT, NegativePrompts, TextRanking

N_MAPS, N_INSTANCES, N_ABSENT, N_VIEWS = 60, 60, 120, 20


@pytest.mark.parametrize("threshold", [threshold_among, picture_threshold_among])
def test_one_map_is_asked_as_ever_and_more_of_them_rising(threshold):
    assert threshold(0.0) == threshold(1.0) == pytest.approx(PRESENT)
    among = [threshold(n) for n in (1, 2, 10, 30, 31, 1000, 100_000)]
    assert among == sorted(among)
    assert len(set(among)) == len(among)
    assert among[-1] < 1


def best_scores(real_data, seed, every):
    """The best score (maps, names) of each absent name in each map, and of each instance by its own name."""
    rng = np.random.default_rng(seed)
    exemplars = Exemplars.read(real_data / "clip-vit-b32" / "lvis.npz")
    negatives = NegativePrompts(exemplars.names[::every], exemplars.text[::every])
    order = rng.permutation(len(exemplars.names))
    absent, pool = order[:N_ABSENT], order[N_ABSENT:]
    of_absent, of_own = [], []
    for _ in range(N_MAPS):
        rows = rng.choice(pool, N_INSTANCES, replace=False)
        # The mean of 20 views, each at a cosine of 0.7 to the exemplar.
        noise = rng.standard_normal((N_INSTANCES, 512)).astype(np.float32) / np.sqrt(512 * N_VIEWS)
        vectors = 0.7 * exemplars.image[rows] + np.sqrt(0.51).astype(np.float32) * noise
        vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
        ranking = TextRanking(EmbeddingTable.of({i: (v[None], np.ones(1)) for i, v in enumerate(vectors)}), negatives)
        of_absent.append(ranking.scores(exemplars.text[absent]).max(axis=0))
        of_own.append(np.diag(ranking.scores(exemplars.text[rows])))
    return np.array(of_absent), np.array(of_own)


@pytest.mark.full
@pytest.mark.parametrize(("seed", "every"), [(10, 1), (11, 3)])
def test_false_alarms_do_not_grow_with_the_number_of_maps(real_data, seed, every):
    absent, own = best_scores(real_data, seed, every)
    of_one = (absent >= PRESENT).mean()
    for n in (3, 10, 30, 60):
        of_many = np.array([absent[start : start + n].max(axis=0) for start in range(0, N_MAPS, n)])
        assert (of_many >= threshold_among(n)).mean() < 1.35 * of_one
        assert (of_many >= PRESENT).mean() > 1.8 * of_one  # what a fixed threshold would do
        assert (own >= threshold_among(n)).mean() > 0.25
