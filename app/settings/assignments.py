"""Parser of "name=value" texts, as --set takes them."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from razer.errors import BadInput
from razer.files import parse_toml


def split_assignment(assignment: str, form: str, known: Collection[str] | None = None) -> tuple[str, str]:
    """Name and value of a text "name=value"; raises BadInput.

    `form` shows how to write it, such as "rule=value"; the name has to be one of `known`, if given."""
    name, separator, value = (part.strip() for part in assignment.partition("="))
    if not separator or not name or (known is not None and name not in known):
        raise BadInput(f"--set {assignment}: write {form}")
    return name, value


def parse_value(text: str) -> Any:
    """A value as TOML reads it; what is no TOML value is a string, so that quotes are optional."""
    try:
        return parse_toml(f"value = {text}", "--set")["value"]
    except BadInput:
        return text
