"""Normal forms of phrases, by hand-made cases."""

from __future__ import annotations

import pytest

from razer.query.phrases import alternatives, plain, singulars, verb_forms, without_openings, without_particles


def test_a_plain_phrase_has_no_case_marks_or_determiners():
    assert plain("  The Dining-Table, please!") == "dining table please"
    assert plain("glass (drink container)") == "glass drink container"
    assert plain("throw_away my trash") == "throw away trash"
    assert plain("?!") == ""


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("cups and plates", ["cups", "plates"]),
        ("cups, plates, and bowls", ["cups", "plates", "bowls"]),
        ("a knife or a fork / spoon", ["a knife", "a fork", "spoon"]),
        ("sandbox", ["sandbox"]),
        ("orange", ["orange"]),
        ("", []),
    ],
)
def test_enumerations_fall_into_their_parts(text, parts):
    assert alternatives(text) == parts


def test_openings_go_one_by_one_and_tell_whether_a_verb_follows():
    assert list(without_openings("something to sit on")) == [
        ("something to sit on", False), ("to sit on", False), ("sit on", True)
    ]  # fmt: skip
    assert ("cooking", True) in without_openings("things used for cooking")
    assert ("sleep", True) in without_openings("where can i sleep")
    assert ("furniture", False) in without_openings("pieces of furniture")
    assert list(without_openings("red chair to sit on")) == [("red chair to sit on", False)]
    assert list(without_openings("")) == []


@pytest.mark.parametrize(
    ("plural", "singular"),
    [
        ("chairs", "chair"), ("dishes", "dish"), ("coffee tables", "coffee table"), ("berries", "berry"),
        ("knives", "knife"), ("shelves", "shelf"), ("people", "person"), ("mice", "mouse"), ("boxes", "box"),
    ],
)  # fmt: skip
def test_singulars(plural, singular):
    assert singular in singulars(plural)
    assert singulars(plural)[0] == plural


def test_what_is_too_short_is_no_plural():
    assert singulars("gas") == ["gas"]
    assert singulars("") == [""]


@pytest.mark.parametrize(
    ("verb", "gerund"),
    [
        ("sit on", "sitting on"), ("write", "writing"), ("sleep", "sleeping"), ("lie down", "lying down"),
        ("see in dark", "seeing in dark"), ("cut", "cutting"), ("read", "reading"), ("eat with", "eating with"),
    ],
)  # fmt: skip
def test_gerunds(verb, gerund):
    assert gerund in verb_forms(verb)
    assert verb_forms(verb)[0] == verb


def test_particles_go_from_the_end():
    assert list(without_particles("lie down on")) == ["lie down on", "lie down", "lie"]
    assert list(without_particles("read")) == ["read"]
    assert list(without_particles("on")) == ["on"]
