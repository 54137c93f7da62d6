"""What words stand for among class names: by hand, and against a judgement of each name of each kind."""

from __future__ import annotations

import csv
from collections import Counter
from pathlib import Path

import pytest

from razer.query.kinds import all_kinds, expand, near_kinds
from razer.query.phrases import plain
from razer.vocabulary import FOLDER, VOCABULARIES, vocabulary

COCO = vocabulary("coco").names
# Each pair was judged one by one, in random order, with pairs mixed in that WordNet or chance suggests.
JUDGED = Path(__file__).parents[2] / "fixtures" / "judged_kinds.csv"


def stands_for(text, names=COCO):
    """{name: the kind as which it is meant}, or None."""
    found = expand(text, names)
    return None if found is None else {names[row]: kind for row, kind in zip(found.rows, found.kinds, strict=True)}


def judged_pairs():
    rows = list(csv.DictReader(JUDGED.read_text(encoding="utf-8").splitlines()))
    return {(row["kind"], plain(row["name"])): row["right"] == "1" for row in rows}


@pytest.mark.parametrize("name", VOCABULARIES)
def test_kinds_are_right_on_the_vocabularies_shipped(name):
    judged, names = judged_pairs(), vocabulary(name).names
    answers = {kind.name: stands_for(kind.name, names) or {} for kind in all_kinds()}
    pairs = [(kind, plain(name)) for answer in answers.values() for name, kind in answer.items() if kind]
    assert len(pairs) >= 10
    assert sum(judged.get(pair, False) for pair in pairs) >= 0.95 * len(pairs), [p for p in pairs if not judged.get(p)]


def test_the_table_as_a_whole_is_right_and_the_judge_says_no_at_times():
    judged = judged_pairs()
    pairs = [(kind.name, plain(name)) for kind in all_kinds() for name in kind.names]
    assert len(pairs) > 1500
    assert sum(judged.get(pair, False) for pair in pairs) >= 0.95 * len(pairs)
    assert sum(not right for right in judged.values()) > 100


@pytest.mark.parametrize(
    ("kind", "supercategory"),
    [
        ("animal", "bird cat dog horse sheep cow elephant bear zebra giraffe"),
        ("vehicle", "bicycle car motorcycle airplane bus train truck boat"),
        ("food", "banana apple sandwich orange broccoli carrot|hot dog|pizza donut cake"),
        ("electronics", "tv laptop mouse remote keyboard|cell phone"),
    ],
)
def test_kinds_are_the_supercategories_that_coco_publishes(kind, supercategory):
    expected = [name for part in supercategory.split("|") for name in ([part] if part in COCO else part.split())]
    assert stands_for(kind) == dict.fromkeys(expected, kind)


SEATS = {"bench": "seat", "chair": "seat", "couch": "seat"}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("something to sit on", SEATS),
        ("Somewhere to sit down?", SEATS),
        ("where can I sit", SEATS),
        ("things for sitting on", SEATS),
        ("seating", SEATS),
        ("furniture that people sit on", SEATS),
        ("a device that tells the time", {"clock": "clock"}),
        ("furniture", dict.fromkeys(["bench", "chair", "couch", "bed", "dining table"], "furniture")),
        ("all pieces of furniture", dict.fromkeys(["bench", "chair", "couch", "bed", "dining table"], "furniture")),
        ("dishes", dict.fromkeys(["wine glass", "cup", "bowl"], "dishes")),
        ("something to drink from", {"cup": "drinkware", "wine glass": "drinkware"}),
        ("something to drink", {}),
        ("something to eat with", dict.fromkeys(["fork", "knife", "spoon"], "cutlery")),
        ("a place to wash my hands", {"sink": "sink"}),
        ("a fridge", {"refrigerator": "refrigerator"}),
        ("chairs and cups", {"chair": None, "cup": None}),
        ("people", {"person": None}),
        (
            "something to read or to cut with",
            {"book": "reading matter", "knife": "cutting tool", "scissors": "cutting tool"},
        ),
        ("something to look at myself in", {}),
    ],
)
def test_what_a_phrase_stands_for(text, expected):
    assert stands_for(text) == expected


@pytest.mark.parametrize(
    "text",
    ["person", "cup", "zorb", "a red chair", "something not to sit on", "furniture and zorbs", "water", "to", ""],
)
def test_names_themselves_and_what_is_no_kind_stand_for_nothing_else(text):
    assert stands_for(text) is None


def test_a_name_is_not_widened_by_what_a_kind_is_called_besides():
    """Shelves are called bookcases, yet a shelf is none where there is a name for bookcases."""
    assert stands_for("bookcases", ("bookcase", "shelf")) == {"bookcase": None}
    assert stands_for("bookcases", ("shelf", "tv")) == {"shelf": "shelf"}


def test_of_two_equal_names_the_first_counts():
    assert stands_for("furniture", ("tv stand", "tv-stand", "zorb")) == {"tv stand": "furniture"}


def test_each_word_asks_for_one_kind_and_each_kind_has_names():
    words = Counter(plain(word) for kind in all_kinds() for word in kind.words)
    assert [word for word, count in words.items() if count > 1] == []
    for kind in all_kinds():
        assert kind.names
        assert len(set(kind.names)) == len(kind.names)


def test_every_purpose_is_understood_as_it_is_asked_for():
    names = tuple(name for kind in all_kinds() for name in kind.names)
    for kind in all_kinds():
        for purpose in kind.purposes:
            found = stands_for(f"something to {purpose}", names)
            assert found is not None, purpose
            assert {plain(name) for name in kind.names} <= {plain(name) for name in found}, purpose


def test_near_kinds():
    assert near_kinds("furnitur") == ["furniture"]
    assert near_kinds("electronic devices")[0] == "electronics"
    assert near_kinds("zorb") == []


def test_the_table_bears_the_notice_that_wordnet_asks_for():
    text = (FOLDER / "kinds.toml").read_text(encoding="utf-8")
    assert "WordNet 3.0 Copyright 2006 by Princeton University" in text
    assert "Permission to use, copy, modify and distribute" in text
