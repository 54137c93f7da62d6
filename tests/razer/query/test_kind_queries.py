"""Maps asked for kinds: exact names first, sets of names by what they share, encoders left alone."""

from __future__ import annotations

import numpy as np
import pytest

from app.ablation.exemplars import Exemplars
from app.ablation.query_protocol import Protocol, banks_of, noisy_observations
from razer.boxes.oriented_box import OrientedBox
from razer.config import BankSettings
from razer.errors import BadInput
from razer.map_object import MapObject
from razer.mesh.labelled_mesh import LabelledMesh
from razer.panoptic_map import PanopticMap
from razer.query.embedding_table import EmbeddingTable
from razer.query.kinds import all_kinds, expand
from razer.query.naming import NameShares
from razer.query.ranking import PRESENT, NegativePrompts, TextRanking
from razer.query.text_queries import TextQueryEncoder
from tests.support.named_vectors import unit_rows


class Names:
    """A table of names whose vectors are unit vectors of their own, all equally far from each other."""

    def __init__(self, *names):
        self.known_names = names

    def embed_texts(self, texts):
        if unknown := set(texts) - set(self.known_names):
            raise BadInput(f"the table has no {unknown}")
        return np.eye(len(self.known_names) + 1, dtype=np.float32)[[self.known_names.index(text) for text in texts]]


class Tower:
    """A text encoder; it notes what it is asked."""

    def __init__(self):
        self.asked = []

    def embed_texts(self, texts):
        self.asked += texts
        return unit_rows([np.bincount(np.frombuffer(t.encode(), np.uint8), minlength=256) for t in texts])


def panoptic_map(embedder, vectors):
    """A map whose instances 1, 2, ... have one vector each."""
    box = OrientedBox(np.zeros(3), np.eye(3), np.ones(3))
    objects = tuple(
        MapObject(i, None, 1.0, box, 10, 10, 5, 0, 9, unit_rows([vector]), np.ones(1))
        for i, vector in enumerate(vectors, start=1)
    )
    nothing = np.zeros((0, 3), np.int32)
    mesh = LabelledMesh(nothing.astype(np.float32), nothing.astype(np.uint8), nothing[:, 0], nothing)
    return PanopticMap(objects, mesh, TextQueryEncoder(embedder))


def furnished(*present, names=("chair", "couch", "desk", "tv", "cup", "furniture")):
    table = Names(*names)
    return panoptic_map(table, [table.embed_texts([name])[0] for name in present])


def found(answer):
    return {hit.object.id: (hit.through, hit.kind) for hit in answer.hits}


def test_a_purpose_finds_the_names_that_serve_it():
    panoptic = furnished("tv", "chair", "couch", "desk", "cup")
    assert found(panoptic.query("something to sit on")) == {2: ("chair", "seat"), 3: ("couch", "seat")}
    assert found(panoptic.query("something to drink from or to watch")) == {
        1: ("tv", "television"),
        5: ("cup", "drinkware"),
    }
    assert found(panoptic.query("cups and desks")) == {4: ("desk", None), 5: ("cup", None)}


def test_an_exact_name_counts_first_and_its_kind_where_nothing_is_called_so():
    assert found(furnished("chair", "tv", "furniture").query("furniture")) == {3: (None, None)}
    assert found(furnished("chair", "tv").query("furniture")) == {1: ("chair", "furniture")}
    assert found(furnished("tv").query("furniture")) == {}
    assert found(furnished("couch").query("cup", threshold=0.0)) == {1: (None, None)}


def test_one_that_cannot_be_told_among_names_of_a_kind_is_of_the_kind():
    """A chair or a couch, it is a seat for certain; a chair or a tv is none."""
    table = Names("chair", "couch", "desk", "tv", "cup")
    between = table.embed_texts(["chair"])[0] + table.embed_texts(["couch"])[0]
    between_kinds = table.embed_texts(["chair"])[0] + table.embed_texts(["tv"])[0]
    answer = panoptic_map(table, [between, between_kinds]).query("something to sit on", threshold=0.0)
    scores = {hit.object.id: hit.score for hit in answer.hits}
    assert scores[1] > 0.95
    assert scores[2] < PRESENT


def test_what_is_like_no_name_is_of_no_kind():
    """Of three names two are seats: what is like none of them is as much like each."""
    names = ("chair", "couch", "tv")
    like_none = np.eye(4)[3]
    panoptic = panoptic_map(Names(*names), [like_none, np.eye(4)[1]])
    assert found(panoptic.query("something to sit on")) == {2: ("couch", "seat")}


def test_without_instances_nothing_is_found_and_an_unknown_word_is_still_refused():
    assert found(furnished().query("something to sit on")) == {}
    with pytest.raises(BadInput, match="the table has no"):
        furnished().query("zorb")
    with pytest.raises(BadInput, match="none of the 6 names"):
        furnished("chair").query("something to eat")


def test_a_map_of_another_embedder_is_refused():
    panoptic = panoptic_map(Names("chair", "tv"), [np.ones(7)])
    with pytest.raises(BadInput, match="vectors of 3 numbers"):
        panoptic.query("something to sit on")


def test_a_text_tower_gets_the_phrase_as_it_stands():
    tower = Tower()
    panoptic = panoptic_map(tower, tower.embed_texts(["a photo of a chair."]))
    answer = panoptic.query("something to sit on", threshold=0.0)
    assert "a photo of a something to sit on." in tower.asked
    assert found(answer) == {1: (None, None)}


def test_kinds_of_things_that_real_vectors_show_through_noise(real_data):
    """Of 60 things of LVIS, each seen 20 times at a cosine of 0.7: every kind against every thing."""
    exemplars = Exemplars.read(real_data / "clip-vit-b32" / "lvis.npz")
    scores, truth = [], []
    for seed in range(2):
        rng = np.random.default_rng(seed)
        rows = rng.permutation(len(exemplars.names))[:60]
        table = EmbeddingTable.of(banks_of(noisy_observations(exemplars, rows, rng, Protocol()), BankSettings()))
        ranking = TextRanking(table, NegativePrompts(exemplars.names, exemplars.text))
        for kind in all_kinds():
            meaning = expand(kind.name, exemplars.names)
            if meaning is not None and len(meaning.rows) > 1:
                shares = NameShares(table, exemplars.text).set_shares(meaning.rows)
                scores.append(np.minimum(shares, ranking.set_scores(exemplars.text[meaning.rows])))
                truth.append(np.isin(rows, meaning.rows))
    score, right = np.concatenate(scores), np.concatenate(truth)
    present = score >= PRESENT
    print(f"precision {right[present].mean():.3f}, recall {present[right].mean():.3f}")
    assert right[present].mean() > 0.8
    assert present[right].mean() > 0.65
    # They are probabilities: of those at 0.4 to 0.8 about as many are right as they say.
    between = (score > 0.4) & (score < 0.8)
    assert abs(score[between].mean() - right[between].mean()) < 0.15
