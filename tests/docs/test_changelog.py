"""The changes name every setting that was renamed, and the site shows every page."""

from __future__ import annotations

import re
from pathlib import Path

from app.settings.config_file import RENAMED
from tests.docs.test_references import GENERATED

ROOT = Path(__file__).resolve().parents[2]


def test_renamed_settings_are_those_of_the_program():
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+\.\w+)` \| `(\w+\.\w+)` \|$", text, re.MULTILINE)
    modules = ("razer.", "slam.", "data_tools.", "app.")
    assert {was: now for was, now in rows if not was.startswith(modules)} == RENAMED


def test_the_site_shows_every_page():
    text = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    shown = set(re.findall(r"^ +- .*: ([\w/]+\.md)$", text, re.MULTILINE))
    generated = {*GENERATED, "index.md", *(f"api/{package}.md" for package in ("razer", "slam", "data_tools"))}
    pages = {path.relative_to(ROOT / "docs").as_posix() for path in (ROOT / "docs").rglob("*.md")}
    records = {page for page in pages if re.match(r"decisions/\d{4}-", page)}
    assert shown == (pages - records) | generated


def test_the_index_of_decisions_lists_each_record_in_order():
    folder = ROOT / "docs" / "decisions"
    listed = re.findall(r"^\| (\d+) \| \[[^\]]+\]\((\d{4}-[\w-]+\.md)\) \|$", (folder / "index.md").read_text(), re.M)
    assert [name for _, name in listed] == sorted(path.name for path in folder.glob("[0-9]*.md"))
    assert [int(number) for number, _ in listed] == list(range(1, len(listed) + 1))


def test_each_decision_has_its_four_parts():
    for path in (ROOT / "docs" / "decisions").glob("[0-9]*.md"):
        parts = re.findall(r"^## (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
        assert parts == ["Context", "Choice", "Measured", "When to revisit"], path.name
