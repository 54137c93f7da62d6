"""Texts to vectors, and the names they are set against."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from razer.errors import BadInput
from razer.models.appearance import AppearanceEmbedder
from razer.models.oracle.embedder import OracleEmbedder
from razer.query.text_queries import NEUTRAL, TEMPLATES, TextQueryEncoder
from razer.vocabulary import VOCABULARIES, vocabulary
from tests.support.named_vectors import unit_rows


class Encoder:
    """A text encoder that notes what it is asked, and turns letters into numbers."""

    def __init__(self):
        self.asked = []

    def embed_texts(self, texts):
        self.asked += texts
        return unit_rows([np.bincount(np.frombuffer(t.encode(), np.uint8), minlength=256) for t in texts])


class Table(Encoder):
    known_names = ("chair", "table")

    def embed_texts(self, texts):
        if not set(texts) <= set(self.known_names):
            raise BadInput("unknown name")
        return super().embed_texts(texts)


def test_an_encoder_is_asked_by_prompts_whose_vectors_are_averaged():
    encoder = Encoder()
    found = TextQueryEncoder(encoder).vectors(["a red chair", "Sofa"])
    prompts = [template.format(text) for text in ("red chair", "Sofa") for template in TEMPLATES]
    assert encoder.asked == prompts
    each = encoder.embed_texts(prompts).reshape(2, len(TEMPLATES), -1).mean(axis=1)
    assert_allclose(found, unit_rows(each), atol=1e-6)


def test_a_table_is_asked_by_bare_names_and_compares_with_all_of_them():
    table = Table()
    words = TextQueryEncoder(table)
    words.vectors(["the chair"])
    assert table.asked == ["chair"]
    assert words.negatives.names == ("chair", "table")
    assert words.knows("table")
    assert not words.knows("sofa")


def test_an_encoder_compares_with_a_sample_of_lvis_and_neutral_words_embedded_once():
    encoder = Encoder()
    words = TextQueryEncoder(encoder)
    assert words.negatives is words.negatives
    assert len(encoder.asked) == len(TEMPLATES) * len(words.negative_names)
    assert set(NEUTRAL) < set(words.negative_names)
    assert len(words.negative_names) > 400


def test_the_oracle_knows_any_name():
    words = TextQueryEncoder(OracleEmbedder())
    assert words.negative_names == vocabulary("lvis").names
    assert_allclose(words.vectors(["a chair"])[0], OracleEmbedder().class_vector("chair"), atol=1e-6)


def test_an_embedder_without_a_text_side_says_so():
    with pytest.raises(BadInput, match=r"no text encoder.*no words.*--image"):
        TextQueryEncoder(AppearanceEmbedder()).vectors(["chair"])


@pytest.mark.parametrize("texts", [[""], ["chair", "  "], []])
def test_nothing_cannot_be_asked_for(texts):
    with pytest.raises(BadInput, match="empty text"):
        TextQueryEncoder(Encoder()).vectors(texts)


def test_shipped_vocabularies_of_things():
    assert len(vocabulary("lvis").names) == 1203
    coco = vocabulary("coco")
    assert len(coco.names) == 80
    assert (coco.by_name["person"].id, coco.by_name["chair"].id, coco.by_name["toothbrush"].id) == (1, 62, 90)


def test_a_table_of_one_name_is_refused():
    table = Table()
    table.known_names = ("chair",)
    with pytest.raises(BadInput, match="single name"):
        _ = TextQueryEncoder(table).negatives


class Furnished(Table):
    """A table with synonyms, which `known_names` leaves out."""

    known_names = ("chair", "couch", "desk", "cup")

    def embed_texts(self, texts):
        return super().embed_texts(["couch" if text == "furniture of padding" else text for text in texts])


def test_a_table_understands_kinds_and_an_encoder_is_left_to_itself():
    table = TextQueryEncoder(Furnished())
    meaning = table.meaning("something to sit on")
    assert [table.choices.names[row] for row in meaning.rows] == ["chair", "couch"]
    assert meaning.kinds == ("seat", "seat")
    for text in ("cup", "a red chair", "furniture of padding", "  "):
        assert table.meaning(text) is None
    assert TextQueryEncoder(Encoder()).meaning("something to sit on") is None


def test_the_oracle_chooses_from_all_names_that_are_shipped():
    words = TextQueryEncoder(OracleEmbedder())
    names = [words.choices.names[row] for row in words.meaning("furniture").rows]
    assert {"couch", "sofa", "tv-stand", "night stand", "furniture"} <= set(names)
    assert {name for one in VOCABULARIES for name in vocabulary(one).names} <= set(words.choices.names)


def test_what_a_table_lacks_is_refused_with_kinds_that_it_may_be_asked_for():
    words = TextQueryEncoder(Furnished())
    with pytest.raises(BadInput, match=r"unknown name; it can be asked for kinds, too, such as furniture$"):
        words.query_vector("furnitur")
    with pytest.raises(BadInput, match=r'unknown name; .*such as furniture or "something to sit on"'):
        words.query_vector("zorb")
    with pytest.raises(BadInput, match="none of the 4 names that the embedder knows is meant by 'something to eat'"):
        words.meaning("something to eat")
    with pytest.raises(BadInput, match=r"^an empty text means nothing[^;]*$"):
        words.query_vector(" ")
    assert_allclose(words.query_vector("a cup"), words.vectors(["cup"]))
