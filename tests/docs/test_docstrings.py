"""No public name without a docstring: ruff's D1 asks for them, and this asks that nothing escapes ruff."""

from __future__ import annotations

import ast
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = sorted(
    path for room in ("app", "razer", "slam", "data_tools") for path in (ROOT / room).rglob("__init__.py")
)
# Magic methods and __init__ are told by their class; packages are asked for below, as ruff skips them.
MAY_BE_LEFT_OUT = {"D104", "D105", "D107"}


def test_ruff_asks_for_docstrings():
    lint = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["ruff"]["lint"]
    assert "D1" in lint["select"]
    assert {rule for rule in lint["ignore"] if rule.startswith("D")} <= MAY_BE_LEFT_OUT
    assert set(lint["per-file-ignores"]) == {"tests/*"}


@pytest.mark.parametrize("path", PACKAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_packages_say_what_they_are(path):
    assert ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))


def test_no_docstring_check_is_switched_off_in_a_line():
    for path in (path for room in ("app", "razer", "slam", "data_tools") for path in (ROOT / room).rglob("*.py")):
        assert "noqa: D" not in path.read_text(encoding="utf-8"), path
