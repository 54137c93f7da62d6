"""`PanopticMap.show`: what is installed draws the page, and what cannot be shown says so."""

from __future__ import annotations

import webbrowser
from importlib.metadata import EntryPoint

import pytest

from app.page.browser_page import show_run
from razer import load_map, panoptic_map
from razer.errors import BadInput
from tests.support.edited_maps import hand_made, saved


def install(monkeypatch, *points):
    monkeypatch.setattr(panoptic_map, "entry_points", lambda group: points if group == "razer.viewers" else ())


def test_a_map_in_memory_says_that_it_is():
    with pytest.raises(BadInput, match="in memory only: save it"):
        hand_made().show()


def test_without_the_program_it_is_said(monkeypatch, tmp_path):
    install(monkeypatch)
    with pytest.raises(BadInput, match="nothing is installed that shows maps"):
        load_map(saved(tmp_path / "map")).show()


def test_the_page_of_the_folder_is_opened(monkeypatch, tmp_path):
    opened, folder = [], saved(tmp_path / "map")
    monkeypatch.setattr(webbrowser, "open", lambda address: opened.append(address))
    install(monkeypatch, EntryPoint("page", "app.page.browser_page:show_run", "razer.viewers"))
    page = load_map(folder).show()
    text = page.read_text(encoding="utf-8")
    assert "<title>map · RAZER</title>" in text
    assert '{"kind":"inline"}' in text.replace(" ", ""), "it needs no server"
    assert opened == [page.as_uri()]
    assert folder not in page.parents


def test_the_entry_point_that_is_declared_is_there():
    import tomllib
    from pathlib import Path

    project = tomllib.loads((Path(__file__).resolve().parents[3] / "pyproject.toml").read_text())["project"]
    assert project["entry-points"]["razer.viewers"] == {"page": "app.page.browser_page:show_run"}
    assert callable(show_run)
