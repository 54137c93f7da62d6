"""The page of the method names each departure from the paper that a preset takes back, with the value that does it."""

from __future__ import annotations

import re
from pathlib import Path

from app.settings.presets import DEPARTURES, PAPER

PAGE = Path(__file__).resolve().parents[2] / "docs" / "method.md"
SETTING = re.compile(r"`(\w+\.\w+) = ([^`]+)`")


def written(value: object) -> str:
    """A value as TOML has it; a whole number without its point."""
    text = f'"{value}"' if isinstance(value, str) else str(value).lower()
    return text.removesuffix(".0")


def named_settings() -> dict[str, str]:
    """The settings in the second column, where the page says how a departure is taken back."""
    table = PAGE.read_text(encoding="utf-8").split("## Where it departs from the paper")[1].split("\n## ")[0]
    rows = [row.split(" | ") for row in table.splitlines() if row.startswith("| ")]
    return {name: value for row in rows for name, value in SETTING.findall(row[1])}


def test_every_departure_is_named_on_the_page_of_the_method() -> None:
    named = named_settings()
    for departure, changes in DEPARTURES.items():
        assert changes.keys() <= named.keys(), departure


def test_what_the_page_names_is_what_the_preset_sets() -> None:
    assert named_settings() == {name: written(value) for name, value in PAPER.items()}
