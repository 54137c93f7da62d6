"""Retrieval by text with real CLIP vectors: noise, neighbours, and what is not there."""

from __future__ import annotations

import numpy as np
import pytest

from app.ablation.exemplars import Exemplars
from app.ablation.query_ablation import mean_scores, measure_queries
from app.ablation.query_protocol import Protocol, noisy_observations
from razer.errors import BadInput

DRAWS = 6


@pytest.fixture(scope="module")
def lvis(real_data):
    return Exemplars.read(real_data / "clip-vit-b32" / "lvis.npz")


@pytest.fixture(scope="module")
def measured(lvis):
    return {name: mean_scores(scores) for name, scores in measure_queries(lvis, DRAWS).items()}


def test_observations_are_of_their_object_at_the_cosine_asked_for(lvis):
    rows = np.arange(30)
    observations = noisy_observations(lvis, rows, np.random.default_rng(0), Protocol(neighbour_share=1 / 3))
    assert observations.shape == (30, 20, 512)
    np.testing.assert_allclose(np.linalg.norm(observations, axis=2), 1, atol=1e-5)
    own = np.isclose((observations * lvis.image[rows][:, None]).sum(axis=2), 0.7, atol=1e-4)
    assert (own.sum(axis=1) == 13).all()
    nearest = (observations @ lvis.image.T).max(axis=2)
    assert nearest.min() > 0.69


def test_absent_names_share_no_synonym_with_present_ones(lvis):
    present, absent = lvis.present_and_absent(60, np.random.default_rng(1))
    assert len(present) == len(absent) == 60
    words = set().union(*(lvis.synonyms[row] for row in present))
    assert not any(lvis.synonyms[row] & words for row in absent)


def test_names_are_found_nearly_as_well_as_without_noise(measured):
    clean, bank = measured["without noise"], measured["bank, own"]
    assert bank["top1"] >= clean["top1"] - 0.05  # 3.0 points over 100 draws; a few draws vary by one or two
    assert bank["top5"] >= clean["top5"] - 0.04
    assert bank["text_top1"] >= 0.9


def test_the_bank_is_as_good_as_a_running_mean_and_better_with_a_neighbour(measured):
    for part in ("top1", "top5", "text_top1", "present_recall"):
        assert measured["bank, own"][part] >= measured["mean, own"][part] - 0.005
        assert measured["bank, with neighbour"][part] >= measured["mean, with neighbour"][part] + 0.02


def test_what_is_present_is_told_from_what_is_not(measured):
    for name in ("bank, own", "bank, with neighbour"):
        assert measured[name]["precision_at_recall"]["0.8"] >= 0.88
        assert measured[name]["present_precision"] >= 0.88
        assert measured[name]["present_recall"] >= 0.76


@pytest.mark.parametrize("content", [b"", b"no archive"])
def test_a_file_that_is_no_table_is_refused(tmp_path, content):
    (tmp_path / "t.npz").write_bytes(content)
    with pytest.raises(BadInput, match=r"t\.npz is no table"):
        Exemplars.read(tmp_path / "t.npz")
    np.savez(tmp_path / "u.npz", names=np.array(["a"]))
    with pytest.raises(BadInput, match=r"u\.npz is no table"):
        Exemplars.read(tmp_path / "u.npz")
