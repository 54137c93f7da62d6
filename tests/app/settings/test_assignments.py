"""Texts "name=value", as every --set takes them."""

from __future__ import annotations

import pytest

from app.settings.assignments import parse_value, split_assignment
from razer.errors import BadInput


@pytest.mark.parametrize("text", ["a=1", " a = 1 ", "a =1"])
def test_name_and_value_lose_the_blanks_around_them(text):
    assert split_assignment(text, "name=value") == ("a", "1")


def test_a_value_may_hold_the_sign_itself():
    assert split_assignment("a=b=c", "name=value") == ("a", "b=c")


@pytest.mark.parametrize("text", ["a", "=1", "", "b=1"])
def test_what_is_no_assignment_or_has_another_name_is_refused(text):
    with pytest.raises(BadInput, match=f"^--set {text}: write name=value$"):
        split_assignment(text, "name=value", {"a"})


@pytest.mark.parametrize(
    ("text", "value"), [("3", 3), ("[1, 2]", [1, 2]), ("true", True), ("full", "full"), ("1,2", "1,2"), ("'x'", "x")]
)
def test_a_value_is_toml_or_else_text(text, value):
    assert parse_value(text) == value
