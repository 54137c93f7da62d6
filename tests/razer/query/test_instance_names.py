"""Names by votes and embeddings in one probability."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from razer.boxes.oriented_box import OrientedBox
from razer.class_votes import ClassVote
from razer.errors import BadInput
from razer.map_object import MapObject
from razer.mesh.labelled_mesh import LabelledMesh
from razer.panoptic_map import PanopticMap
from razer.query.naming import ranked_names
from razer.query.text_queries import TextQueryEncoder
from razer.semantics.labelling import best_names, label
from razer.vocabulary import Category
from tests.support.named_vectors import unit_rows

DIMENSION = 48
WORDS = ("armchair", "couch", "stool", "table", "desk", "lamp", "cup", "bowl", "door", "window", "rug", "clock")


class Table:
    """A table of names: seats are alike, and so are tables; "sofa" is the couch."""

    def __init__(self, names=WORDS, embeds_names=False):
        rng = np.random.default_rng(5)
        vectors = {word: rng.standard_normal(DIMENSION) for word in WORDS}
        for one, other in (("couch", "armchair"), ("stool", "armchair"), ("desk", "table"), ("bowl", "cup")):
            vectors[one] = 0.75 * vectors[other] + 0.65 * vectors[one]
        self.known_names, self.embeds_names = tuple(names), embeds_names
        self.rows = {word: unit_rows(vectors[word]) for word in names}
        if "couch" in self.rows:
            self.rows["sofa"] = self.rows["couch"]

    def embed(self, frame, masks):
        return np.zeros((len(masks), DIMENSION), np.float32)

    def embed_texts(self, texts):
        if unknown := [text for text in texts if text not in self.rows]:
            raise BadInput(f"the table does not know '{unknown[0]}'")
        return np.stack([self.rows[text] for text in texts])


def votes(*said: tuple[str, int], frames: int = 3, score: float = 0.7) -> tuple[ClassVote, ...]:
    """Votes by (name, sector)."""
    return tuple(ClassVote(name, sector, frames, 0.4 * frames, score) for name, sector in said)


def looks_like(table: Table, name: str, cosine: float = 0.7, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng([seed, WORDS.index(name)])
    true = table.rows[name] if name in table.rows else Table().rows[name]
    aside = rng.standard_normal(DIMENSION)
    aside -= (aside @ true) * true
    return (cosine * true + np.sqrt(1 - cosine**2) * aside / np.linalg.norm(aside)).astype(np.float32)


def a_map(objects, table=None):
    """A map of instances 1, 2, ...: (votes, vector) each."""
    items = tuple(
        MapObject(
            id=number,
            class_name=None,
            score=0.9,
            box=OrientedBox(np.zeros(3), np.eye(3), np.ones(3)),
            n_voxels=10,
            n_vertices=0,
            observations=3,
            first_frame=0,
            last_frame=9,
            embeddings=vector[None],
            weights=np.ones(1),
            class_votes=said,
        )
        for number, (said, vector) in enumerate(objects, start=1)
    )
    nothing = np.zeros((0, 3), np.float32)
    mesh = LabelledMesh(nothing, nothing, np.zeros(0, np.int32), np.zeros((0, 3), np.int32))
    return PanopticMap(items, mesh, TextQueryEncoder(table or Table()))


def furnished(first, table=None):
    """A map whose first instance is given, among others that are called what they look like."""
    table = table or Table()
    others = [(votes((word, 1), (word, 2)), looks_like(Table(), word)) for word in WORDS if word in table.rows]
    return a_map([first, *others], table)


def chances(panoptic, names=WORDS):
    return dict(zip(names, panoptic.name_probabilities(names)[0], strict=True))


def test_probabilities_add_up_to_one_whatever_is_known_of_an_instance():
    table = Table()
    rng = np.random.default_rng(2)
    stranger = unit_rows(rng.standard_normal(DIMENSION))
    panoptic = a_map([(votes(("couch", 0)), looks_like(table, "lamp")), ((), stranger), ((), looks_like(table, "cup"))])
    probability = panoptic.name_probabilities(WORDS)
    assert_allclose(probability.sum(axis=1), 1)
    assert probability.min() >= 0
    assert probability[1].max() < probability[2].max()  # what is like no name in particular is less sure


def test_a_name_said_from_half_of_the_sides_is_settled_by_the_embedding():
    said = votes(("armchair", 0), ("armchair", 1), ("armchair", 2), ("couch", 3), ("couch", 4), ("couch", 5))
    table = Table()
    for name in ("armchair", "couch"):
        panoptic = furnished((said, looks_like(table, name)))
        assert best_names(panoptic, WORDS)[1] == name
        # By the votes alone neither is more probable.
        parts = panoptic.instance_names.parts(["armchair", "couch"])
        assert parts.said[0, 0] == pytest.approx(parts.said[0, 1])


def test_votes_and_vectors_in_conflict():
    """One glance is doubted where the vector says something else; what is said from all sides is believed."""
    vector = looks_like(Table(), "lamp", cosine=0.9)
    glance, all_round = (
        furnished((votes(*(("door", i) for i in range(n)), frames=m, score=s), vector))
        for n, m, s in ((1, 1, 0.4), (6, 20, 0.8))
    )
    assert chances(glance)["lamp"] > chances(glance)["door"]
    assert chances(all_round)["door"] > 0.5 > chances(all_round)["lamp"]


def test_more_evidence_is_a_higher_probability():
    vector = unit_rows(np.random.default_rng(3).standard_normal(DIMENSION))
    by_sides = [chances(furnished((votes(*(("cup", i) for i in range(n))), vector)))["cup"] for n in range(6)]
    assert (np.diff(by_sides) > 0).all()
    by_score = [chances(furnished((votes(("cup", 0), score=s), vector)))["cup"] for s in (0.4, 0.6, 0.8)]
    assert (np.diff(by_score) > 0).all()
    by_vector = [chances(furnished((votes(("cup", 0)), looks_like(Table(), "cup", c))))["cup"] for c in (0, 0.5, 0.9)]
    assert (np.diff(by_vector) > 0).all()


def test_the_order_of_instances_and_of_names_changes_nothing():
    panoptic = furnished((votes(("couch", 0), ("stool", 1)), looks_like(Table(), "stool")))
    other = PanopticMap(panoptic.objects[::-1], panoptic.mesh, panoptic.text_queries)
    mixed = list(WORDS[::-1])
    expected = panoptic.name_probabilities(WORDS)
    assert_allclose(other.name_probabilities(mixed)[::-1, ::-1], expected, rtol=1e-4, atol=1e-9)


def test_a_synonym_of_what_was_said_counts_as_said():
    said = votes(("sofa", 0), ("sofa", 1), ("sofa", 2))
    panoptic = furnished((said, looks_like(Table(), "couch")))
    assert best_names(panoptic, WORDS)[1] == "couch"
    assert chances(panoptic)["couch"] > 0.8


def test_a_list_without_the_detectors_name_takes_one_like_it():
    """Said is "armchair", which is not on the list; the vector says nothing."""
    vector = unit_rows(np.random.default_rng(9).standard_normal(DIMENSION))
    names = [word for word in WORDS if word != "armchair"]
    panoptic = furnished((votes(*(("armchair", i) for i in range(4))), vector))
    found = chances(panoptic, names)
    assert found["couch"] + found["stool"] > 0.5


def test_a_table_without_the_detectors_name_goes_by_the_vector():
    table = Table([word for word in WORDS if word != "armchair"])
    panoptic = furnished((votes(("armchair", 0), ("armchair", 1)), looks_like(table, "lamp", 0.9)), table)
    assert not panoptic.instance_names.has_votes[0]
    assert best_names(panoptic, [word for word in WORDS if word != "armchair"])[1] == "lamp"


def test_vectors_of_the_names_said_are_no_second_witness():
    """An embedder of names says what the votes say: each side once, and not twice."""
    said = votes(("armchair", 0), ("couch", 1), ("couch", 2))
    vector = Table().rows["armchair"]  # fifty good views of one side
    by_votes, by_both = (chances(furnished((said, vector), Table(embeds_names=same))) for same in (True, False))
    assert by_votes["couch"] > 2 * by_votes["armchair"]
    assert by_both["couch"] < 2 * by_both["armchair"]


def test_without_votes_names_are_those_of_the_embeddings_alone():
    """As of runs that were written before votes were."""
    table = Table()
    rng = np.random.default_rng(4)
    panoptic = a_map([((), looks_like(table, WORDS[rng.integers(12)], 0.5, i)) for i in range(9)])
    order = ranked_names(panoptic.embedding_table, panoptic.text_vectors(WORDS))
    assert [WORDS[row[0]] for row in order] == list(best_names(panoptic, WORDS).values())


def test_an_ambiguous_label_names_the_runner_up():
    said = votes(("armchair", 0), ("couch", 1))
    sure = votes(*(("lamp", i) for i in range(6)))
    between = unit_rows(Table().rows["armchair"] + Table().rows["couch"])
    panoptic = a_map([(said, between), (sure, looks_like(Table(), "lamp"))])
    categories = [Category(number, word, 0, "", False) for number, word in enumerate(WORDS, start=1)]
    first, second = label(panoptic, categories)
    assert first.is_ambiguous
    assert {first.category.name, first.runner_up.name} == {"armchair", "couch"}
    assert first.score + first.runner_up_score <= 1
    assert second.category.name == "lamp"
    assert not second.is_ambiguous


def test_a_query_says_what_else_a_hit_may_be():
    said = votes(("armchair", 0), ("couch", 1))
    between = unit_rows(Table().rows["armchair"] + Table().rows["couch"])
    panoptic = a_map([(said, between), *((votes((w, 0), (w, 1)), looks_like(Table(), w)) for w in ("lamp", "cup"))])
    armchair, couch = (panoptic.query(name, 0.2).hits[0] for name in ("armchair", "couch"))
    assert armchair.object.id == couch.object.id == 1
    assert (armchair.runner_up[0], couch.runner_up[0]) == ("couch", "armchair")
    assert armchair.score == pytest.approx(couch.runner_up[1], abs=0.02)
    assert armchair.score + armchair.runner_up[1] <= 1
    lamp = panoptic.query("lamp").hits[0]
    assert (lamp.object.id, lamp.runner_up) == (2, None)
    assert not panoptic.query("window").found
