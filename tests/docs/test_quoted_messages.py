"""The messages that the page of troubles quotes are those that the program has."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "when_it_goes_wrong.md"
ROOMS = ("app", "razer", "slam", "data_tools")
VALUE = "…"  # what a text of the program and a quotation have where a name or a number stands
_LEAST = 15  # letters of a quotation that says something


def quoted() -> list[str]:
    """The code in the first cells of the page's tables that says something: options and names are shorter."""
    rows = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    return [text for row in rows for text in re.findall(r"`([^`]+)`", row.split(" | ")[0]) if len(text) >= _LEAST]


def text_of(node: ast.AST) -> str | None:
    """The text of a literal with each value as one sign; None for anything else."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else None
    if isinstance(node, ast.JoinedStr):
        return "".join(text_of(part) or VALUE for part in node.values)
    return None


@cache
def said() -> tuple[str, ...]:
    """Every text of the program."""
    trees = (ast.parse(p.read_text(encoding="utf-8")) for room in ROOMS for p in (ROOT / room).rglob("*.py"))
    return tuple(text for tree in trees for node in ast.walk(tree) if (text := text_of(node)))


def is_said(quotation: str) -> bool:
    """Whether a text of the program holds the words of a quotation in their order, apart from values."""
    pieces = [re.escape(piece.strip()) for piece in quotation.split(VALUE) if piece.strip()]
    return any(re.search(".*".join(pieces), text, re.DOTALL) for text in said())


@pytest.mark.parametrize("quotation", quoted())
def test_the_program_says_what_is_quoted(quotation):
    assert is_said(quotation)


def test_enough_is_quoted():
    assert len(quoted()) > 20


def test_what_nobody_says_is_found_out():
    assert not is_said("the camera could not be found")
    assert not is_said("could not be located the camera")
    assert is_said(f"frames {VALUE} to {VALUE}")
