"""Names that people gave: certain, by words and by vectors, whatever votes and embeddings say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from razer.errors import BadInput
from razer.models import make_embedder
from razer.query.given_names import GivenNames, same_words
from razer.query.text_queries import TextQueryEncoder
from razer.semantics.labelling import probable_names
from tests.support.edited_maps import CHAIR, LAMP, OTHER_CHAIR, TABLE, hand_made


class Wordless:
    """An embedder that knows no words, as `appearance`."""

    def embed(self, frame, masks):
        return np.zeros((len(masks), 4), np.float32)


class Encoder:
    """A text encoder: texts are alike as far as they share words."""

    def embed(self, frame, masks):
        return np.zeros((len(masks), 64), np.float32)

    def embed_texts(self, texts):
        rows = [
            sum(_vector(word) for word in text.strip(".").split() if word not in ("a", "of", "the")) for text in texts
        ]
        return np.stack([row / np.linalg.norm(row) for row in rows]).astype(np.float32)


def _vector(word: str) -> np.ndarray:
    return np.random.default_rng(list(word.encode())).standard_normal(64)


def named(names, encoder=None, **fields):
    """The hand-made map with some instances named by people."""
    base = hand_made()
    objects = tuple(
        replace(o, class_name=names[o.id], is_named_by_hand=True, is_edited=True) if o.id in names else o
        for o in base.objects
    )
    return replace(base, objects=objects, **({} if encoder is None else {"text_queries": encoder}), **fields)


def ids(answer):
    return {hit.object.id: hit.score for hit in answer.hits}


@pytest.mark.parametrize("text", ["grandma's throne", "a Grandma's Throne", "grandma's thrones"])
def test_the_new_name_finds_it_for_certain(text):
    assert ids(named({CHAIR: "grandma's throne"}).query(text)) == {CHAIR: 1.0}


def test_the_former_name_does_not_find_it_though_all_votes_are_for_it():
    panoptic = named({CHAIR: "lamp"})
    assert ids(hand_made().query("a chair")).keys() == {CHAIR, OTHER_CHAIR}
    assert ids(panoptic.query("a chair")).keys() == {OTHER_CHAIR}
    assert ids(panoptic.query("a chair", 0.0))[CHAIR] == 0.0
    assert ids(panoptic.query("lamp")).keys() == {LAMP, CHAIR}
    assert ids(panoptic.query("lamp"))[CHAIR] == 1.0


def test_a_kind_finds_what_was_named_as_one_of_it():
    panoptic = named({LAMP: "grandma's armchair", TABLE: "vase"})
    hits = {hit.object.id: hit for hit in panoptic.query("something to sit on").hits}
    assert hits.keys() == {CHAIR, OTHER_CHAIR, LAMP}
    assert (hits[LAMP].through, hits[LAMP].kind, hits[LAMP].score) == ("grandma's armchair", "seat", 1.0)
    assert TABLE not in ids(panoptic.query("furniture"))
    # Of exactly this name something is there: the kind of the same name is not asked.
    assert ids(named({LAMP: "armchair"}).query("chair")).keys() == {CHAIR, OTHER_CHAIR}


def test_labels_take_the_given_name_where_the_list_has_it():
    names = ["chair", "lamp", "table", "sofa"]
    panoptic = named({CHAIR: "Lamps", TABLE: "grandma's throne"})
    rows = dict(zip(panoptic.embedding_table.ids.tolist(), panoptic.name_probabilities(names), strict=True))
    assert rows[CHAIR].tolist() == [0, 1, 0, 0]
    assert probable_names(panoptic, names)[CHAIR] == ("lamp", 1.0)
    np.testing.assert_allclose(panoptic.name_probabilities(names).sum(axis=1), 1.0)
    base = hand_made()
    np.testing.assert_allclose(
        rows[OTHER_CHAIR], base.name_probabilities(names)[base.embedding_table.ids == OTHER_CHAIR][0]
    )


@pytest.mark.parametrize("encoder", [None, TextQueryEncoder(Wordless())])
def test_without_words_of_its_own_a_map_answers_by_given_names(encoder):
    panoptic = replace(named({LAMP: "reading lamp", CHAIR: "stool"}), text_queries=encoder)
    assert ids(panoptic.query("reading lamps")) == {LAMP: 1.0}
    assert ids(panoptic.query("something to sit on")) == {CHAIR: 1.0}
    with pytest.raises(BadInput, match=r"no text encoder|no embedder"):
        panoptic.query("table")
    with pytest.raises(BadInput):
        panoptic.query(" ")


def test_an_encoder_judges_by_the_name_and_not_by_the_picture():
    given = GivenNames({1: "red office chair", 2: "lamp"}, TextQueryEncoder(Encoder()))
    near, far = given.asked("office chair", by_kind=False), given.asked("bathtub", by_kind=False)
    assert near[1].score > 0.6 > near[2].score
    assert max(match.score for match in far.values()) < 0.6
    chances = given.probabilities(["office chair", "bathtub", "table lamp"])
    assert chances[1].argmax() == 0
    assert chances[2].argmax() == 2
    assert sum(chances[1]) == pytest.approx(1)


def test_a_name_that_a_table_lacks_says_nothing_about_a_list(monkeypatch):
    class Table:
        known_names = ("chair", "lamp")

        def embed(self, frame, masks): ...

        def embed_texts(self, texts):
            if unknown := set(texts) - set(self.known_names):
                raise BadInput(f"the table has no {unknown}")
            return np.stack([_vector(text) for text in texts]).astype(np.float32)

    given = GivenNames({1: "throne"}, TextQueryEncoder(Table()))
    assert given.probabilities(["chair", "lamp"]) == {}
    assert given.asked("chair", by_kind=False)[1].score == 0


def test_words_are_the_same_but_for_articles_case_and_number():
    assert same_words("The Chairs", "a chair")
    assert same_words("shelf", "shelves")
    assert not same_words("chair", "armchair")
    assert not same_words("office chair", "chair")


def test_pictures_are_not_asked_for_names():
    vector = make_embedder("oracle", {}).embed_texts(["chair"])[0]
    assert ids(named({CHAIR: "lamp"}).query_image(vector)).keys() == {CHAIR, OTHER_CHAIR}
